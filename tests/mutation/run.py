"""Mutation run: does a test turn red whatever is changed in the ego, the guard, the merger, the blame, the verdict?

    .venv/bin/python tests/mutation/run.py                 # all files; goes on where it was broken off
    .venv/bin/python tests/mutation/run.py --file guard    # only files with this in their name
    .venv/bin/python tests/mutation/run.py --write         # and keep the survivors, with the reasons given before

A mutant is killed if a test fails or does not end. Each one is judged by the unit tests of its file alone, in a process
forked from one that has everything else loaded, with the compiled parts left uncompiled; nothing is written to the
source tree. Fails where the score of all is below the bar or a survivor has no reason in survivors.json.
"""

import os

os.environ["NUMBA_DISABLE_JIT"] = "1"
os.environ["PYTEST_DISABLE_PLUGIN_AUTOLOAD"] = "1"

import argparse
import gc
import hashlib
import importlib.abc
import importlib.util
import json
import re
import resource
import signal
import sys
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

import hypothesis
import numpy as np
import pytest
from mutants import Mutant, find_mutants
from rich.progress import Progress
from targets import BAR, SOURCE, TARGETS, Target

REPOSITORY = Path(__file__).parents[2]
SURVIVORS = Path(__file__).with_name("survivors.json")
JOURNAL = Path(__file__).parent / "__pycache__" / "verdicts.jsonl"
PATIENCE = 5  # [s] of CPU time, then a mutant counts as one that does not end
LOADED = ("roadmend.repair.registry", "roadmend.world.simulation")


@dataclass
class Result:
    """What became of a file's mutants."""

    mutants: int = 0
    survivors: list[Mutant] = field(default_factory=list)

    @property
    def score(self) -> float:
        return 1.0 - len(self.survivors) / self.mutants if self.mutants else 1.0


class _Changed(importlib.abc.MetaPathFinder, importlib.abc.InspectLoader):
    """Imports one module from a changed source."""

    def __init__(self, target: Target, source: str) -> None:
        self._target, self._source = target, source

    def find_spec(self, name, path, target=None):
        if name != self._target.module:
            return None
        return importlib.util.spec_from_loader(name, self, origin=str(self._target.path))

    def get_source(self, fullname):
        return self._source


def load() -> None:
    """Load what the tests need, once for all mutants."""
    sys.path.insert(0, str(SOURCE.parent))
    # Compiled code reads a field of a record as an attribute; uncompiled it needs this type of record for that.
    scene = importlib.import_module("roadmend.core.scene")
    scene.OBJECT = np.dtype((np.record, scene.OBJECT))
    for name in LOADED:
        importlib.import_module(name)
    gc.freeze()  # a child that went through all of this would copy it


class _Hasty:
    """Ends the process at the first test that fails, or after the last: nobody waits for it to be tidy."""

    @staticmethod
    def pytest_runtest_logreport(report):
        if report.failed:
            os._exit(1)

    @staticmethod
    def pytest_sessionfinish(exitstatus):
        os._exit(int(exitstatus))


UNUSED = ("cacheprovider", "unraisableexception", "threadexception", "logging", "faulthandler", "doctest", "junitxml")


def _run_tests(target: Target) -> int:
    words = [
        "-q",
        "-p",
        "pytest_timeout",
        "--assert=plain",
        *(word for name in UNUSED for word in ("-p", f"no:{name}")),
    ]
    return pytest.main([*words, *(str(REPOSITORY / "tests" / test) for test in target.tests)], [_Hasty])


def _imported(path: Path) -> set[str]:
    """The project's modules that a file names in its imports."""
    lines = re.findall(r"^ *from (roadmend[\w.]*) import (.*)", path.read_text(encoding="utf-8"), re.MULTILINE)
    names = {f"{package}.{name.partition(' ')[0]}" for package, words in lines for name in words.split(", ")}
    return {package for package, _ in lines} | names


def _path_of(module: str) -> Path | None:
    path = SOURCE.parent.joinpath(*module.split("."))
    return next((each for each in (path.with_suffix(".py"), path / "__init__.py") if each.is_file()), None)


def _closure(files: Iterable[Path]) -> set[Path]:
    """Some files and all of the project's that they import, and those that these do."""
    found, fresh = set(), set(files)
    while fresh:
        found |= fresh
        fresh = {each for path in fresh for name in _imported(path) if (each := _path_of(name))} - found
    return found


@cache
def _dependents(target: Target) -> frozenset[str]:
    """The target and all loaded modules that import it, or another that does."""
    loaded = {name: path for name in sys.modules if name.startswith("roadmend.") and (path := _path_of(name))}
    return frozenset(name for name, path in loaded.items() if target.path in _closure([path]))


def _silence() -> None:
    sink = os.open(os.devnull, os.O_WRONLY)
    os.dup2(sink, 1)
    os.dup2(sink, 2)


def is_noticed(target: Target, source: str) -> bool:
    """Whether the tests of a file fail on this source of it, or do not end."""
    stale = _dependents(target)
    child = os.fork()
    if child == 0:
        code = 1
        try:
            _silence()
            resource.setrlimit(resource.RLIMIT_CPU, (PATIENCE, PATIENCE + 1))
            for name in stale:
                sys.modules.pop(name, None)
            sys.meta_path.insert(0, _Changed(target, source))
            code = int(_run_tests(target))
        finally:
            os._exit(code)
    _, status = os.waitpid(child, 0)
    if os.WIFSIGNALED(status) and os.WTERMSIG(status) == signal.SIGINT:
        raise KeyboardInterrupt
    return status != 0


def _digest(*parts: str) -> str:
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()


def _surroundings(target: Target) -> str:
    """Digest of all that the verdict on a mutant hangs on, the mutant itself excepted."""
    tests = [REPOSITORY / "tests" / test for test in target.tests]
    helpers = {path for test in tests for path in test.parent.glob("*.py") if not path.name.startswith("test_")}
    files = sorted(_closure({target.path, *tests, *helpers}) - {target.path})
    return _digest(*(path.read_text(encoding="utf-8") for path in files))


class Journal:
    """Verdicts so far, one line each, so that a run that is broken off goes on."""

    def __init__(self, path: Path) -> None:
        path.parent.mkdir(exist_ok=True)
        self._path = path
        self._known: dict[str, bool] = {}
        if path.exists():
            for line in path.read_text(encoding="utf-8").splitlines():
                key, _, verdict = line.partition(" ")
                self._known[key] = verdict == "killed"

    def judge(self, target: Target, surroundings: str, mutant: Mutant) -> bool:
        """Whether a mutant is killed, from the journal if it is there.

        Raises:
            SystemExit: a file that the verdict hangs on was changed meanwhile.
        """
        key = _digest(surroundings, mutant.source)
        if key not in self._known:
            self._known[key] = is_noticed(target, mutant.source)
            if _surroundings(target) != surroundings:
                raise SystemExit(f"{target.file}: what it is tested with was changed meanwhile; start again")
            with self._path.open("a", encoding="utf-8") as file:
                file.write(f"{key} {'killed' if self._known[key] else 'survived'}\n")
        return self._known[key]


def judge_all(targets: list[Target], progress: Progress) -> Iterator[tuple[Target, Result]]:
    """Judge the mutants of some files, one after another.

    Raises:
        SystemExit: the tests fail on the file as it is.
    """
    journal = Journal(JOURNAL)
    for target in targets:
        bar = progress.add_task(target.file, total=None)
        if is_noticed(target, target.path.read_text(encoding="utf-8")):
            raise SystemExit(f"{target.file}: its tests fail, or take {PATIENCE} s, before anything is changed")
        surroundings, result = _surroundings(target), Result()
        mutants = find_mutants(target.path, target.functions, target.left_out)
        progress.update(bar, total=len(mutants))
        for mutant in mutants:
            result.mutants += 1
            if not journal.judge(target, surroundings, mutant):
                result.survivors.append(mutant)
            progress.advance(bar)
        yield target, result


def load_reasons() -> dict[str, dict[str, str]]:
    """Why a survivor may live, by file and name."""
    if not SURVIVORS.exists():
        return {}
    kept = json.loads(SURVIVORS.read_text(encoding="utf-8"))
    return {file: record["survivors"] for file, record in kept.items()}


def main() -> int:
    """Judge, show and perhaps keep."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--file", default="", help="only files with this in their path")
    parser.add_argument("--json", action="store_true", help="print the result as JSON")
    parser.add_argument("--write", action="store_true", help="keep scores and survivors, with the reasons known so far")
    options = parser.parse_args()
    profile = hypothesis.settings(
        database=None, derandomize=True, phases=[hypothesis.Phase.generate], max_examples=30, deadline=None
    )
    hypothesis.settings.register_profile("mutation", profile)
    hypothesis.settings.load_profile("mutation")
    chosen = [target for target in TARGETS if options.file in target.file]
    reasons = load_reasons()
    load()
    begun = time.monotonic()
    with Progress(disable=not sys.stderr.isatty()) as progress:
        results = dict(judge_all(chosen, progress))
    records = {
        target.file: {
            "mutants": result.mutants,
            "score": round(result.score, 4),
            "survivors": {
                mutant.name: reasons.get(target.file, {}).get(mutant.name, "") for mutant in result.survivors
            },
        }
        for target, result in results.items()
    }
    total = Result(sum(r.mutants for r in results.values()), [m for r in results.values() for m in r.survivors])
    if options.json:
        print(json.dumps(records, indent=1))
    else:
        for target, result in results.items():
            print(f"{target.file}: {result.mutants - len(result.survivors)} of {result.mutants}, {result.score:.1%}")
            for mutant in result.survivors:
                reason = records[target.file]["survivors"][mutant.name]
                print(f"  {mutant.line} {mutant.name}\n      {reason or 'NOT EXPLAINED'}")
        print(f"all: {total.score:.1%} of {total.mutants} killed in {time.monotonic() - begun:.0f} s")
    if options.write:
        kept = json.loads(SURVIVORS.read_text(encoding="utf-8")) if SURVIVORS.exists() else {}
        SURVIVORS.write_text(json.dumps({**kept, **records}, indent=1, sort_keys=True) + "\n", encoding="utf-8")
    explained = all(all(record["survivors"].values()) for record in records.values())
    return 0 if explained and total.score >= BAR else 1


if __name__ == "__main__":
    sys.exit(main())
