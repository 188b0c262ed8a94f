"""Options that several benchmarks have, and where their plans are."""

from pathlib import Path

import click
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn

PLANS = Path(__file__).parents[1]
COLUMNS = (  # of the bars of long work
    TextColumn("{task.description}"),
    BarColumn(),
    MofNCompleteColumn(),
    TimeElapsedColumn(),
    TimeRemainingColumn(),
)
COMMITTED = click.option(
    "--committed",
    default=Path("tests/benchmarks"),
    show_default=True,
    type=click.Path(path_type=Path, file_okay=False),
    help="Folder of the committed figures.",
)
CACHED_WORK = click.option(
    "--work",
    type=click.Path(path_type=Path, file_okay=False),
    help="Folder for finished work; an interrupted run goes on.  [default: in the user's cache]",
)
