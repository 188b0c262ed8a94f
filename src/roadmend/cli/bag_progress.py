"""Progress on the terminal for commands that read through a bag."""

import contextlib
from collections.abc import Callable, Iterator

from rich.console import Console
from rich.progress import BarColumn, DownloadColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn


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
