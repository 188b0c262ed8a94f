"""What commands show: tables for people on standard output, progress on standard error."""

import contextlib
import sys
from collections.abc import Callable, Iterator, Sequence

from rich.console import Console
from rich.markup import escape
from rich.progress import (
    BarColumn,
    DownloadColumn,
    MofNCompleteColumn,
    Progress,
    ProgressColumn,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.table import Table

OUTCOME_STYLES = {"GOAL": "green", "COLLISION": "red", "TIMEOUT": "yellow", "OFF_ROUTE": "yellow", "ABORTED": "yellow"}


def wide_console() -> Console:
    """Standard output: as wide as the terminal, and wide enough for any row where there is none."""
    return Console(width=None if sys.stdout.isatty() else 200)


def show_rows(rows: Sequence[Sequence[str]]) -> None:
    """Print a table; the first row is the heading."""
    table = Table(*map(escape, rows[0]), box=None, pad_edge=False, header_style="bold")  # "[s]" is a unit, no style
    for row in rows[1:]:
        table.add_row(*map(escape, row))
    wide_console().print(table)


Report = Callable[[str, int, int | None], None]  # what is being done, how much of it is done, how much there is


def counting(*more: ProgressColumn, is_transient: bool = False) -> Progress:
    """Bars on standard error with what is done, how much of how many, and how long it will take yet.

    Args:
        more: columns.
        is_transient: whether they are gone at the end.
    """
    columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()
    return Progress(*columns, *more, console=Console(stderr=True), transient=is_transient)


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


@contextlib.contextmanager
def bag_progress(title: str, size: int) -> Iterator[Callable[[int], None]]:
    """While this lasts, a bar on the terminal shows how many of ``size`` bytes were passed; gone at the end.

    Yields:
        What to call with the number of bytes passed since the last call.
    """
    columns = (TextColumn("{task.description}"), BarColumn(), DownloadColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task(title, total=size)
        yield lambda count: progress.advance(task, count)


@contextlib.contextmanager
def message_progress(title: str) -> Iterator[Callable[[int], None]]:
    """While this lasts, the terminal shows how many messages were passed.

    Yields:
        What to call with the number of messages passed since the last call.
    """
    columns = (TextColumn("{task.description}"), TextColumn("{task.completed:.0f} messages"), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task(title, total=None)
        yield lambda count: progress.advance(task, count)
