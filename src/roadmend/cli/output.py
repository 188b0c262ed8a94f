"""What commands show: tables for people on standard output, progress on standard error."""

import contextlib
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from typing import Any, Self

from rich.console import Console
from rich.markup import escape
from rich.progress import (
    BarColumn,
    DownloadColumn,
    MofNCompleteColumn,
    Progress,
    ProgressColumn,
    TaskID,
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


_SILENCE = 30.0  # [s] after which work that goes on says so where there is no terminal
_SHARE, _PAUSE = 0.1, 5.0  # or sooner: after so much of it, but not before so many seconds; work as short says nothing

Report = Callable[[str, int, int | None], None]  # what is being done, how much of it is done, how much there is
ToldReport = Callable[[str, int, int | None, str], None]  # and how it goes


def counting(*more: ProgressColumn, is_transient: bool = False) -> Progress:
    """Bars on standard error with what is done, how much of how many, and how long it will take yet.

    Args:
        more: columns.
        is_transient: whether they are gone at the end.
    """
    columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()
    return _progress(*columns, *more, is_transient=is_transient)


def _progress(*columns: ProgressColumn, is_transient: bool) -> Progress:
    console = Console(stderr=True)
    if not console.is_terminal:
        return ProgressLines(console)
    return Progress(*columns, console=console, transient=is_transient)


class ProgressLines(Progress):
    """Progress where there is no terminal, in a log say: a line now and then about what has moved, and one at its end."""

    def __init__(self, console: Console) -> None:
        super().__init__(console=console, disable=True)  # the bars; the lines are printed beside
        self._begin = self._said_at = time.monotonic()
        self._said: dict[TaskID, float] = {}

    def update(self, task_id: TaskID, **changes: Any) -> None:
        """As the bars', and perhaps a line."""
        super().update(task_id, **changes)
        self._say(task_id)

    def advance(self, task_id: TaskID, advance: float = 1) -> None:
        """As the bars', and perhaps a line."""
        super().advance(task_id, advance)
        self._say(task_id)

    def reset(self, task_id: TaskID, **changes: Any) -> None:
        """As the bars': the task begins anew, under another name perhaps."""
        self._said.pop(task_id, None)
        super().reset(task_id, **changes)

    def _say(self, task_id: TaskID) -> None:
        task = self._tasks[task_id]
        now, before = time.monotonic(), self._said.get(task_id, 0.0)
        if task.completed <= before:
            return
        silence = now - self._said_at
        share = (task.completed - before) / task.total if task.total else 0.0
        is_done = task.total is not None and task.completed >= task.total
        if not (
            (is_done and now - self._begin >= _PAUSE) or silence >= _SILENCE or (share >= _SHARE and silence >= _PAUSE)
        ):
            return
        self._said[task_id], self._said_at = task.completed, now
        of = "" if task.total is None else f" of {task.total:,.0f}"
        left = "" if is_done or task.time_remaining is None else f", about {task.time_remaining:.0f} s left"
        self.console.print(
            f"{task.description}: {task.completed:,.0f}{of} after {now - self._begin:.0f} s{left}",
            markup=False,
            highlight=False,
            soft_wrap=True,
        )


class Waiting:
    """Work that cannot be counted: a status on a terminal, a line now and then where there is none.

    Args:
        title: of the work.
    """

    def __init__(self, title: str) -> None:
        self._console = Console(stderr=True)
        self._title = self._text = title
        self._status = self._console.status(escape(title)) if self._console.is_terminal else None
        self._over = threading.Event()

    def __enter__(self) -> Self:
        if self._status is not None:
            self._status.start()
        else:
            threading.Thread(target=self._tell, daemon=True).start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        if self._status is not None:
            self._status.stop()

    def update(self, text: str) -> None:
        """How far it is now."""
        self._text = f"{self._title}: {text}"
        if self._status is not None:
            self._status.update(escape(self._text))

    def say(self, text: str) -> None:
        """Say what stays on the screen."""
        self._print(f"{self._title}: {text}")

    def _tell(self) -> None:
        while not self._over.wait(_SILENCE):
            self._print(self._text)

    def _print(self, text: str) -> None:
        self._console.print(text, markup=False, highlight=False, soft_wrap=True)


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
    told = _told_stages_of(progress)
    return lambda what, done, total: told(what, done, total, "")


def stage_of(progress: Progress) -> Report:
    """Shows the stage under way in one bar, which begins anew with each: the time left is of the stage alone."""
    task = progress.add_task("", total=None)
    label, last = "", 0

    def report(what: str, done: int, total: int | None) -> None:
        nonlocal label, last
        if what != label or done < last:
            progress.reset(task, description=what, total=total)
        label, last = what, done
        progress.update(task, completed=done, total=total)

    return report


@contextlib.contextmanager
def told_stages() -> Iterator[ToldReport]:
    """As ``stages``, and every bar says how it goes.

    Yields:
        What to call as a stage goes on.
    """
    with counting(TextColumn("{task.fields[how]}")) as progress:
        yield _told_stages_of(progress)


def _told_stages_of(progress: Progress) -> ToldReport:
    tasks: dict[str, TaskID] = {}

    def report(what: str, done: int, total: int | None, how: str) -> None:
        if what not in tasks:
            tasks[what] = progress.add_task(what, total=total, how=how)
        progress.update(tasks[what], completed=done, total=total, how=how)

    return report


@contextlib.contextmanager
def bag_progress(title: str, size: int) -> Iterator[Callable[[int], None]]:
    """While this lasts, a bar on the terminal shows how many of ``size`` bytes were passed; gone at the end.

    Yields:
        What to call with the number of bytes passed since the last call.
    """
    columns = (TextColumn("{task.description}"), BarColumn(), DownloadColumn(), TimeRemainingColumn())
    with _progress(*columns, is_transient=True) as progress:
        task = progress.add_task(title, total=size)
        yield lambda count: progress.advance(task, count)


@contextlib.contextmanager
def message_progress(title: str) -> Iterator[Callable[[int], None]]:
    """While this lasts, the terminal shows how many messages were passed.

    Yields:
        What to call with the number of messages passed since the last call.
    """
    columns = (TextColumn("{task.description}"), TextColumn("{task.completed:.0f} messages"), TimeElapsedColumn())
    with _progress(*columns, is_transient=True) as progress:
        task = progress.add_task(title, total=None)
        yield lambda count: progress.advance(task, count)
