"""Which jobs there are for a number of crashes, and working through them so that a new call goes on.

Apart from the jobs themselves, so that what decides a job's result is not how its report was read.
"""

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from pydantic import TypeAdapter

from roadmend.core.errors import InputError
from roadmend.core.fanout import fan_out
from roadmend.core.journal import Journal, Key
from roadmend.safe.cases import CrashCase
from roadmend.safe.construction import plain_name, roles_of
from roadmend.safe.driving import CrashTestJob, CrashTestResult, Drawing, Task, digest_of, do

_WORK = ".work"  # folder for finished jobs in the output
_FORMAT = "roadmend-safe-work/3"
_PLAIN = TypeAdapter(CrashTestResult)


def plan(
    task: Task,
    cases: Iterable[CrashCase],
    policies: Sequence[str],
    out: Path,
    *,
    samples: int = 1,
    budget: int = 0,
    seed: int = 0,
    draw: Drawing | None = None,
) -> list[CrashTestJob]:
    """The jobs: the ego takes every role of every case in turn.

    Raises:
        InputError: two cases or two policies would write over each other's files.
    """
    readable = [(case.name, case.crash) for case in cases if case.crash is not None]
    _check_names("case", [name for name, _ in readable])
    _check_names("policy", policies)
    return [
        CrashTestJob(task, role, policy, seed, index, budget, out, draw)
        for policy in dict.fromkeys(policies)  # what is named twice counts once
        for name, crash in readable
        for role in roles_of(name, crash)
        for index in range(samples)
    ]


def _check_names(noun: str, given: Iterable[str]) -> None:
    """Raise InputError where two would write over each other's files, which are called by both."""
    found: dict[str, str] = {}
    for each in given:
        name = plain_name(each)
        other = found.setdefault(name, each)
        if other != each:
            raise InputError(f"{noun} {each}", f"is called {name!r} in names of files, as {other} is", "rename one")


def do_all(jobs: Sequence[CrashTestJob], out: Path, workers: int, told: Callable[[int], None]) -> list[CrashTestResult]:
    """Do what has not been done yet; results come in the order of the jobs.

    What failed counts as not done: a full disk or a crashed simulator may be mended by the next call.

    Args:
        jobs: to do.
        out: folder of what is made, and of the finished jobs.
        workers: processes.
        told: hears how many are done.

    Raises:
        InputError: the folder holds something else, or cannot be written.
        SimulationError: a worker process died.
    """
    keys = [job.key for job in jobs]
    with Journal(out / _WORK / "results.jsonl", _FORMAT, owns_folder=True) as journal:
        missing = [(key, job) for key, job in zip(keys, jobs, strict=True) if not _is_done(journal, key, out)]
        before = len(jobs) - len(missing)
        failed: dict[Key, CrashTestResult] = {}
        told(before)
        with fan_out(workers, len(missing)) as mapper:
            answers = mapper(do, [job for _, job in missing])
            for number, ((key, _), result) in enumerate(zip(missing, answers, strict=True), before + 1):
                if result.failed:
                    failed[key] = result
                else:
                    journal.add(key, _PLAIN.dump_python(result, mode="json"))
                told(number)
        kept = [journal.get(key) for key in keys]
    return [failed.get(key) or _PLAIN.validate_python(each) for key, each in zip(keys, kept, strict=True)]


def _is_done(journal: Journal, key: Key, out: Path) -> bool:
    """Whether a result is there, and the files that it names are as they were: the judge goes by them."""
    kept = journal.get(key)
    return kept is not None and all(digest_of(out / file) == digest for file, digest in kept["digests"].items())
