"""``roadmend bench``: figures as ratios, measured in one run."""

import click

from roadmend.cli.bench_loop import loop


@click.group()
def bench() -> None:
    """Measure, in ratios."""


bench.add_command(loop)
