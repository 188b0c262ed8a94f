"""``roadmend bench``: figures as ratios, measured in one run."""

import click

from roadmend.cli.lazy import LazyGroup, Table

_COMMANDS: Table = {
    "adreft": ("roadmend.cli.bench_adreft", "adreft", "Every repair method on every policy, as the paper has it."),
    "loop": ("roadmend.cli.bench_loop", "loop", "What the loop costs beside bare SUMO and a bare ring of nodes."),
    "outcomes": ("roadmend.cli.bench_outcomes", "outcomes", "How a policy fares in random scenarios."),
    "readme": ("roadmend.cli.bench_readme", "readme", "Copy the committed figures into the README."),
    "recorder": ("roadmend.cli.bench_recorder", "recorder", "What the recorder takes in, and what a kill costs."),
    "retrieval": ("roadmend.cli.bench_retrieval", "retrieval", "Searching a bank of a million scenarios."),
    "safe": ("roadmend.cli.bench_safe", "safe", "Crash reports into scenarios, beside the paper's figures."),
    "sera": ("roadmend.cli.bench_sera", "sera", "What policies learn from recommended scenarios."),
}


@click.group(cls=LazyGroup, table=_COMMANDS)
def bench() -> None:
    """Measure, in ratios."""
