"""``roadmend bench``: figures as ratios, measured in one run."""

import click

from roadmend.cli.bench_adreft import adreft
from roadmend.cli.bench_loop import loop
from roadmend.cli.bench_outcomes import outcomes
from roadmend.cli.bench_readme import readme
from roadmend.cli.bench_recorder import recorder
from roadmend.cli.bench_retrieval import retrieval
from roadmend.cli.bench_safe import safe
from roadmend.cli.bench_sera import sera


@click.group()
def bench() -> None:
    """Measure, in ratios."""


bench.add_command(adreft)
bench.add_command(loop)
bench.add_command(outcomes)
bench.add_command(readme)
bench.add_command(recorder)
bench.add_command(safe)
bench.add_command(retrieval)
bench.add_command(sera)
