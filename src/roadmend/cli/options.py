"""Options that many commands have."""

import os
from pathlib import Path

import click

WORKERS = click.option("--workers", default=os.cpu_count() or 1, show_default="cores", type=click.IntRange(1, 256))
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
