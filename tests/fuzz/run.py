"""Fuzz a reader: ``.venv/bin/python tests/fuzz/run.py READER SECONDS [SEED]``, or ``all`` of them, ``--parallel`` at once.

The seconds are the processor's, so that a busy machine does not make for less. With ``--publish`` each reader's row goes into
fuzz.json and fuzz.md of tests/benchmarks as soon as it is there, and those of others stay; ``--resume`` leaves out the
readers that have theirs, of the same engine, seed and at least as many seconds.

Small files that it reads, and those of ``corpus/`` that once broke one or reach code that others do not, are changed and
read in a process of its own, which is ended where a file takes longer than the documentation allows. ``--engine mutation``
(the default) changes them with a seeded generator; ``--engine atheris`` follows the coverage of the code, and with
``--keep`` leaves what it found in ``corpus/``. Told are the peak of the memory, the slowest file, files a second, and every
exception that is not the documented one; the file of a fault is kept as ``fault-READER-DIGEST`` in the folder this was
called in. A reader that reads none of 100,000 files is a fault too. Exit code 1 if there was one.
"""

import argparse
import ctypes
import json
import os
import signal
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from fuzz_engines import ENGINES
from fuzz_readers import READERS

M_MMAP_THRESHOLD = -3  # of malloc.h
PUBLISHED = Path(__file__).parents[1] / "benchmarks"


def main(arguments: list[str]) -> int:
    """Fuzz the reader of the arguments, or each in a process of its own."""
    parser = argparse.ArgumentParser(description="Fuzz a reader of files from outside.")
    parser.add_argument("reader", choices=["all", *READERS])
    parser.add_argument("seconds", type=float)
    parser.add_argument("seed", type=int, nargs="?", default=1)
    parser.add_argument("--engine", choices=ENGINES, default="mutation")
    parser.add_argument("--parallel", type=int, default=1, help="readers at once")
    parser.add_argument("--keep", action="store_true", help="of atheris: what it found goes into corpus/")
    parser.add_argument("--publish", action="store_true", help="write tests/benchmarks/fuzz.json and fuzz.md")
    parser.add_argument("--resume", action="store_true", help="with --publish: only the readers that have no such row")
    given = parser.parse_args(arguments)
    if given.keep and given.engine != "atheris":
        parser.error("--keep is of --engine atheris")
    if given.resume and not given.publish:
        parser.error("--resume is of --publish")
    names = [*READERS] if given.reader == "all" else [given.reader]
    how = {"engine": given.engine, "seconds": given.seconds, "seed": given.seed}
    if given.resume:
        names = [name for name in names if not _has_row(name, how)]
    publish = Publisher(how, f".venv/bin/python tests/fuzz/run.py {' '.join(arguments)}") if given.publish else None
    rows = fuzz(
        names, given.seconds, given.seed, given.engine, parallel=given.parallel, is_kept=given.keep, publish=publish
    )
    return int(any(found["faults"] for found in rows.values()))


def fuzz(
    names: list[str],
    seconds: float,
    seed: int,
    engine: str,
    *,
    parallel: int = 1,
    is_kept: bool = False,
    publish: Callable[[str, dict[str, object]], object] | None = None,
) -> dict[str, dict[str, object]]:
    """Fuzz readers, each in a process that may take all that it has with it; what came of each, as plain values."""
    waiting, running, rows = [*reversed(names)], dict[int, tuple[str, Path]](), dict[str, dict[str, object]]()
    with tempfile.TemporaryDirectory(prefix="roadmend-fuzz-") as folder:
        while waiting or running:
            while waiting and len(running) < max(1, parallel):
                name = waiting.pop()
                own = Path(folder) / name
                own.mkdir()
                running[_started(name, seconds, seed, engine, own, is_kept=is_kept)] = name, own
            process, status = os.wait()
            name, own = running.pop(process)
            rows[name] = _found(own, status)
            print(f"{name:14}", json.dumps(rows[name]), flush=True)
            if publish is not None:
                publish(name, rows[name])
    return {name: rows[name] for name in names}


def _started(name: str, seconds: float, seed: int, engine: str, folder: Path, *, is_kept: bool) -> int:
    process = os.fork()
    if process == 0:
        # What is freed goes back at once: else the heap keeps holes of the size of the largest changed files, and after
        # some million of them they pass for what the reader takes.
        ctypes.CDLL(None).mallopt(M_MMAP_THRESHOLD, 128 << 10)
        files = folder / "files"
        files.mkdir()
        ENGINES[engine](name, seconds, seed, files, _teller(folder), is_kept=is_kept)
        os._exit(0)
    return process


def _teller(folder: Path) -> Callable[[dict[str, object]], object]:
    return lambda found: (folder / "told.json").write_text(json.dumps(found))


def _found(folder: Path, status: int) -> dict[str, object]:
    told = folder / "told.json"
    if told.exists():
        return json.loads(told.read_text())
    limits = (signal.SIGPROF, signal.SIGALRM)
    what = "took too long" if os.WIFSIGNALED(status) and os.WTERMSIG(status) in limits else "crashed"
    return {"files": 0, "faults": {f"{what} (status {status})": ""}}


class Publisher:
    """Puts rows into the published table, each with how it was made and at which commit."""

    def __init__(self, how: dict[str, object], command: str) -> None:
        from roadmend.reports.result_files import provenance  # late: what is there is not instrumented

        self._how, self._made = how, provenance(command)  # now: later the table itself has changed

    def __call__(self, name: str, found: dict[str, object]) -> None:
        """Write the table with this row in it."""
        from roadmend.reports.result_files import write_report

        rows = _published() | {name: {**self._how, "commit": self._made["commit"], **found}}
        rows = {name: rows[name] for name in READERS if name in rows}
        content = {"format": "roadmend-fuzz/2", "provenance": self._made, "readers": rows}
        names = ("seconds", "files", "accepted", "per_second", "slowest_s", "grown_mb")
        table = [
            ["reader", "seconds", "files", "read", "files a second", "slowest [s]", "memory more [MB]", "faults", "at"]
        ]
        for reader, row in rows.items():
            values = (f"{row[key]:g}" if key == "seconds" else str(row.get(key, "")) for key in names)
            table.append([reader, *values, "; ".join(row["faults"]), row["commit"][:12]])
        write_report(PUBLISHED, "fuzz", "Readers given changed files, by seconds of the processor", content, table)


def _published() -> dict[str, dict[str, Any]]:
    path = PUBLISHED / "fuzz.json"
    return json.loads(path.read_text())["readers"] if path.exists() else {}


def _has_row(name: str, how: dict[str, object]) -> bool:
    row = _published().get(name, {})
    same = all(row.get(key) == how[key] for key in ("engine", "seed"))
    return same and row.get("seconds", 0.0) >= how["seconds"] and not row["faults"]


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
