"""Where the files come from: mutated at random, or by atheris, which goes on from those that reach code no other did."""

import os
import random
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path

from fuzz_account import Account
from fuzz_mutation import SIZE_MAX, mutated
from fuzz_readers import CORPUS, DOCUMENTED, READERS, kept_of, seeds_of

Tell = Callable[[dict[str, object]], object]
_SHARED = {each.__module__ for each in DOCUMENTED}  # errors that the account must know again
KEPT_BYTES = 32_000  # of a reader's corpus, at most
_MOMENT = (2026, 1, 1, 0, 0, 0)  # of every file in it, so that the same files make the same archive


def mutation(name: str, seconds: float, seed: int, folder: Path, tell: Tell, *, is_kept: bool) -> None:
    """Fuzz with a seeded generator and tell what came of it."""
    assert not is_kept  # nobody knows which of them reached new code
    seeds, random_ = seeds_of(name), random.Random(f"{name}/{seed}")
    account, renewed = Account(name, seconds, seeds[0], folder), READERS[name].renewed
    while not account.is_over:
        data = mutated(seeds, random_)
        account.read(renewed(data) if renewed is not None and random_.random() < 0.5 else data)
    tell(account.told())


def coverage(name: str, seconds: float, seed: int, folder: Path, tell: Tell, *, is_kept: bool) -> None:
    """Fuzz with atheris, tell what came of it, and end the process, as libFuzzer would.

    The code of roadmend is followed; what is compiled (libyaml, expat, JSON, safetensors, zstd) is not seen.
    """
    import atheris

    for module in [each for each in sys.modules if each.startswith("roadmend.") and each not in _SHARED]:
        del sys.modules[module]  # loaded before this process began to follow what it loads
    with atheris.instrument_imports(include=["roadmend"]):
        seeds = seeds_of(name)
        account, renewed = Account(name, seconds, seeds[0], folder), READERS[name].renewed
    found = folder.parent / "found"
    found.mkdir()
    for number, content in enumerate(seeds):
        (found / f"seed-{number}").write_bytes(content)

    def give(data: bytes) -> None:
        if account.is_over:
            tell(account.told() | {"found": len([*found.iterdir()]) - len(seeds)})
            if is_kept:
                keep(name, found)
            os._exit(0)
        account.read(data)
        if renewed is not None:
            account.read(renewed(data))

    longest = min(SIZE_MAX, max(4096, *(2 * len(content) for content in seeds)))
    words = [f"-max_len={longest}", f"-seed={seed}", "-timeout=0", "-rss_limit_mb=0", "-verbosity=0", str(found)]
    atheris.Setup([name, *words], give)
    atheris.Fuzz()


ENGINES = {"mutation": mutation, "atheris": coverage}


def keep(name: str, found: Path) -> None:
    """Keep the smallest of what was found, now and before, as the corpus that the reader's next run begins with."""
    contents = {path.read_bytes() for path in found.glob("[!s]*")} | {*kept_of(name)}
    room = KEPT_BYTES
    with zipfile.ZipFile(CORPUS / f"{name}.zip", "w") as archive:
        for number, content in enumerate(sorted(contents, key=lambda content: (len(content), content))):
            room -= len(content)
            if room < 0:
                break
            archive.writestr(zipfile.ZipInfo(f"{number:03}", _MOMENT), content, zipfile.ZIP_DEFLATED)
