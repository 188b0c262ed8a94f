"""Progress on the terminal for commands that work through a number of things."""

import contextlib
from collections.abc import Callable, Iterator

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

Report = Callable[[str, int, int | None], None]  # what is being done, how much of it is done, how much there is


def counting() -> Progress:
    """Bars on standard error with what is done, how much of how many, and how long it will take yet."""
    columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()
    return Progress(*columns, console=Console(stderr=True))


@contextlib.contextmanager
def stages() -> Iterator[Report]:
    """While this lasts, every stage that is reported has a bar of its own.

    Yields:
        What to call as a stage goes on.
    """
    with counting() as progress:
        yield stages_of(progress)


def stages_of(progress: Progress) -> Report:
    """Gives every stage that is reported a bar of its own among the bars of ``progress``."""
    tasks = {}

    def report(what: str, done: int, total: int | None) -> None:
        if what not in tasks:
            tasks[what] = progress.add_task(what, total=total)
        progress.update(tasks[what], completed=done, total=total)

    return report
