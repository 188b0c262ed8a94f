"""Fuzz a reader: ``.venv/bin/python tests/fuzz/run.py READER SECONDS [SEED]``, or ``all`` of them one after the other.

With ``--publish`` fuzz.json and fuzz.md are written into tests/benchmarks.

Small files that it reads, and those of ``corpus/`` that once broke one or reach code that others do not, are changed and
read in a process of its own, which is ended where a file takes longer than the documentation allows. ``--engine mutation``
(the default) changes them with a seeded generator; ``--engine atheris`` follows the coverage of the code, and with
``--keep`` leaves what it found in ``corpus/``. Told are the peak of the memory, the slowest file, files a second, and every
exception that is not the documented one; the file of a fault is kept as ``fault-READER-DIGEST`` in the folder this was
called in. Exit code 1 if there was one.
"""

import argparse
import json
import os
import signal
import sys
import tempfile
from pathlib import Path

from fuzz_engines import ENGINES
from fuzz_readers import READERS

PUBLISHED = Path(__file__).parents[1] / "benchmarks"


def main(arguments: list[str]) -> int:
    """Fuzz the reader of the arguments, or each in a process of its own."""
    parser = argparse.ArgumentParser(description="Fuzz a reader of files from outside.")
    parser.add_argument("reader", choices=["all", *READERS])
    parser.add_argument("seconds", type=float)
    parser.add_argument("seed", type=int, nargs="?", default=1)
    parser.add_argument("--engine", choices=ENGINES, default="mutation")
    parser.add_argument("--keep", action="store_true", help="of atheris: what it found goes into corpus/")
    parser.add_argument("--publish", action="store_true", help="write tests/benchmarks/fuzz.json and fuzz.md")
    given = parser.parse_args(arguments)
    if given.keep and given.engine != "atheris":
        parser.error("--keep is of --engine atheris")
    names = [*READERS] if given.reader == "all" else [given.reader]
    rows = {name: fuzz(name, given.seconds, given.seed, given.engine, is_kept=given.keep) for name in names}
    if given.publish:
        _publish(rows, given.seconds, f".venv/bin/python tests/fuzz/run.py {' '.join(arguments)}")
    return int(any(found["faults"] for found in rows.values()))


def fuzz(name: str, seconds: float, seed: int, engine: str, *, is_kept: bool = False) -> dict[str, object]:
    """Fuzz one reader in a process that may take all that it has with it; what came of it, as plain values."""
    with tempfile.TemporaryDirectory(prefix="roadmend-fuzz-") as folder:
        told = Path(folder) / "told.json"
        process = os.fork()
        if process == 0:
            files = Path(folder) / "files"
            files.mkdir()
            ENGINES[engine](
                name, seconds, seed, files, lambda found: told.write_text(json.dumps(found)), is_kept=is_kept
            )
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
    from roadmend.reports.result_files import provenance, write_report  # late: what is there is not instrumented

    names = ("files", "accepted", "per_second", "slowest_s", "grown_mb")
    table = [["reader", "files", "read", "files a second", "slowest [s]", "memory more [MB]", "faults"]]
    table += [
        [name, *(str(found.get(key, "")) for key in names), "; ".join(found["faults"])] for name, found in rows.items()
    ]
    content = {"format": "roadmend-fuzz/1", "provenance": provenance(command), "seconds": seconds, "readers": rows}
    write_report(PUBLISHED, "fuzz", f"Readers given changed files, {seconds:g} s each", content, table)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
