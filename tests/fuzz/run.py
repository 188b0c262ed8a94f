"""Fuzz a reader: ``.venv/bin/python tests/fuzz/run.py READER SECONDS [SEED]``, or ``all`` of them one after the other.

With ``--publish`` behind that, fuzz.json and fuzz.md are written into tests/benchmarks.

Small files that it reads, and those of ``corpus/`` that once broke one, are mutated with a seeded generator and read in
a process of its own, which is ended where a file takes longer than the documentation allows. Told are the peak of the
memory, the slowest file, files a second, and every exception that is not the documented one; the file of a fault is
kept as ``fault-READER-DIGEST`` in the folder this was called in. Exit code 1 if there was one.
"""

import hashlib
import json
import os
import random
import resource
import signal
import sys
import tempfile
import time
import traceback
from pathlib import Path

from fuzz_mutation import mutated
from fuzz_readers import DOCUMENTED, READERS, place_of, seeds_of
from roadmend.reports.result_files import provenance, write_report

PUBLISHED = Path(__file__).parents[1] / "benchmarks"
TIME_MAX = 10.0  # [s] a file
MEMORY_MAX = 512 << 10  # [KiB] by which the process may grow


def work(name: str, seconds: float, seed: int, folder: Path) -> dict[str, object]:
    """Fuzz for a while; what came of it, as plain values."""
    reader = READERS[name]
    seeds = seeds_of(name)
    random_ = random.Random(f"{name}/{seed}")
    path = place_of(name, folder)
    path.write_bytes(seeds[0])
    reader.read(path)  # what is imported and compiled by the first call is not a file's doing
    before, begin = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, time.monotonic()
    count = accepted = 0
    slowest, faults = (0.0, ""), dict[str, str]()
    while time.monotonic() - begin < seconds:
        data = mutated(seeds, random_)
        path.unlink()
        path.write_bytes(data)
        start, digest = time.monotonic(), hashlib.sha256(data).hexdigest()[:12]
        signal.alarm(int(TIME_MAX))
        try:
            reader.read(path)
            accepted += 1
        except DOCUMENTED as error:
            if "\n" in str(error):
                faults.setdefault("a message of several lines", _keep(name, digest, data))
        except BaseException as error:  # noqa: BLE001 - any other is what is looked for
            place = traceback.extract_tb(error.__traceback__)[-1]
            faults.setdefault(f"{type(error).__name__} at {place.name}:{place.lineno}", _keep(name, digest, data))
        finally:
            signal.alarm(0)
        slowest = max(slowest, (time.monotonic() - start, digest))
        count += 1
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    if grown > MEMORY_MAX:
        faults["memory"] = f"{grown >> 10} MB"
    rate = count / (time.monotonic() - begin)
    return {"files": count, "accepted": accepted, "per_second": round(rate), "slowest_s": round(slowest[0], 3)} | {
        "grown_mb": grown >> 10,
        "faults": faults,
    }


def _keep(name: str, digest: str, data: bytes) -> str:
    kept = Path.cwd() / f"fault-{name}-{digest}"
    kept.write_bytes(data)
    return kept.name


def main(arguments: list[str]) -> int:
    """Fuzz the reader of the arguments, or each in a process of its own."""
    words = [word for word in arguments if word != "--publish"]
    name, seconds, seed = words[0], float(words[1]), int(words[2]) if len(words) > 2 else 1
    rows = {each: _in_a_process(each, seconds, seed) for each in (READERS if name == "all" else [name])}
    if "--publish" in arguments:
        _publish(rows, seconds, f".venv/bin/python tests/fuzz/run.py {' '.join(arguments)}")
    return int(any(found["faults"] for found in rows.values()))


def _in_a_process(name: str, seconds: float, seed: int) -> dict[str, object]:
    """Fuzz one reader in a process that may take all that it has with it."""
    with tempfile.TemporaryDirectory(prefix="roadmend-fuzz-") as folder:
        told = Path(folder) / "told.json"
        process = os.fork()
        if process == 0:
            (Path(folder) / "files").mkdir()
            told.write_text(json.dumps(work(name, seconds, seed, Path(folder) / "files")))
            os._exit(0)
        status = os.waitpid(process, 0)[1]
        if told.exists():
            found = json.loads(told.read_text())
        else:
            what = "took too long" if os.WTERMSIG(status) == signal.SIGALRM else "crashed"
            found = {"files": 0, "faults": {f"{what} (status {status})": ""}}
    print(f"{name:14}", json.dumps(found), flush=True)
    return found


def _publish(rows: dict[str, dict[str, object]], seconds: float, command: str) -> None:
    names = ("files", "accepted", "per_second", "slowest_s", "grown_mb")
    table = [["reader", "files", "read", "files a second", "slowest [s]", "memory more [MB]", "faults"]]
    table += [
        [name, *(str(found.get(key, "")) for key in names), "; ".join(found["faults"])] for name, found in rows.items()
    ]
    content = {"format": "roadmend-fuzz/1", "provenance": provenance(command), "seconds": seconds, "readers": rows}
    write_report(PUBLISHED, "fuzz", f"Readers given changed files, {seconds:g} s each", content, table)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
