"""What the commands of ``roadmend safe`` share: their options, and working through jobs so that a new call goes on."""

from collections.abc import Callable, Sequence
from functools import wraps
from pathlib import Path
from typing import Any

import click

from roadmend.cli.options import WORKERS
from roadmend.cli.output import counting
from roadmend.core.errors import InputError
from roadmend.core.fanout import fan_out
from roadmend.core.journal import Journal, Key
from roadmend.policies.registry import POLICIES
from roadmend.safe.cases import Case, gather_cases
from roadmend.safe.driving import Job, Result, do

WORK = ".work"  # folder for finished jobs in the output
FORMAT = "roadmend-safe-work/1"
policies_option = click.option(
    "--policy",
    "policies",
    multiple=True,
    default=["modular"],
    show_default=True,
    type=click.Choice(sorted(POLICIES)),
    help="May be given more than once.",
)


def shared_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """The arguments and options that all of them have."""
    options = [
        click.argument("paths", nargs=-1, required=True, type=click.Path(path_type=Path)),
        click.option(
            "--out",
            required=True,
            type=click.Path(path_type=Path, file_okay=False),
            help="Folder for what is made; a run that was interrupted there goes on.",
        ),
        click.option("--seed", default=0, show_default=True, type=click.IntRange(0, 2**31 - 1)),
        WORKERS,
        click.option("--json", "as_json", is_flag=True, help="Print JSON."),
    ]

    @wraps(command)
    def wrapped(*args: Any, **kwargs: Any) -> Any:
        return command(*args, **kwargs)

    for option in reversed(options):
        wrapped = option(wrapped)
    return wrapped


def open_cases(paths: Sequence[Path]) -> list[Case]:
    """The cases of the arguments; those that cannot be read are named on standard error.

    Raises:
        InputError: not one can be read.
    """
    cases = gather_cases(paths)
    problems = [case for case in cases if case.crash is None]
    for case in problems:
        click.echo(f"{case.name}: {case.problem}", err=True)
    if len(problems) == len(cases):
        raise InputError(str(paths[0]), "not one crash could be read", "see what is said of each above")
    return cases


def work_through(jobs: Sequence[Job], out: Path, workers: int, label: str) -> list[Result]:
    """Do what has not been done yet; results come in the order of the jobs.

    Raises:
        InputError: the folder holds something else, or cannot be written.
        SimulationError: a worker process died.
    """
    keys = [job.key for job in jobs]
    with Journal(out / WORK / "results.jsonl", FORMAT, owns_folder=True) as journal, counting() as progress:
        open_ends = [(key, job) for key, job in zip(keys, jobs, strict=True) if not _is_done(journal, key, out)]
        task = progress.add_task(label, total=len(jobs), completed=len(jobs) - len(open_ends))
        with fan_out(workers, len(open_ends)) as mapper:
            for (key, _), result in zip(open_ends, mapper(do, [job for _, job in open_ends]), strict=True):
                journal.add(key, result.as_dict())
                progress.advance(task)
        found = [journal.get(key) for key in keys]
    return [Result.from_dict(each) for each in found if each is not None]


def _is_done(journal: Journal, key: Key, out: Path) -> bool:
    """Whether a result is there, and the files that it names are."""
    kept = journal.get(key)
    return kept is not None and all((out / kept[name]).is_file() for name in ("scenario", "picture") if kept[name])
