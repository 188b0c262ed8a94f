"""Fuzz a reader: ``.venv/bin/python tests/fuzz/run.py READER SECONDS [SEED]``, or ``all`` of them one after the other.

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
    name, seconds, seed = arguments[0], float(arguments[1]), int(arguments[2]) if len(arguments) > 2 else 1
    failed = False
    for each in READERS if name == "all" else [name]:
        process = os.fork()
        if process == 0:
            with tempfile.TemporaryDirectory(prefix="roadmend-fuzz-") as folder:
                found = work(each, seconds, seed, Path(folder))
            print(f"{each:14}", json.dumps(found), flush=True)
            os._exit(bool(found["faults"]))
        status = os.waitpid(process, 0)[1]
        if os.WIFSIGNALED(status):
            what = "took too long" if os.WTERMSIG(status) == signal.SIGALRM else "crashed"
            print(f"{each:14} {what} (signal {os.WTERMSIG(status)})", flush=True)
        failed = failed or status != 0
    return int(failed)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
