"""``roadmend sera``: learn from the failures that were recorded."""

import click

from roadmend.cli.lazy import LazyGroup, Table

_COMMANDS: Table = {
    "bank": ("roadmend.cli.sera_bank", "bank", "Build, show, search, export and import a scenario bank."),
    "evaluate": (
        "roadmend.cli.sera_evaluate",
        "evaluate",
        "Drive an evaluation set: four measures, and bags of failures.",
    ),
    "analyse": ("roadmend.cli.sera_analyse", "analyse_bags", "Find the failures in bags, and the patterns in them."),
    "recommend": ("roadmend.cli.sera_recommend", "recommend", "Select scenarios to learn from."),
    "tune": ("roadmend.cli.sera_tune", "tune", "Fine-tune a neural policy on a selection."),
    "cycle": ("roadmend.cli.sera_cycle", "cycle", "Run several generations of all this, and plot them."),
}


@click.group(cls=LazyGroup, table=_COMMANDS)
def sera() -> None:
    """Learn from the failures that were recorded."""
