"""Options that several benchmarks have, and where their plans are."""

from pathlib import Path

import click

PLANS = Path(__file__).parents[1]
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
