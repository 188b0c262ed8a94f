"""``roadmend sera``: learn from the failures that were recorded."""

import click

from roadmend.cli.lazy import LazyGroup, Table

_COMMANDS: Table = {
    "bank": ("roadmend.cli.sera_bank", "bank", "Build, show, search, export and import a scenario bank."),
    "recommend": ("roadmend.cli.sera_recommend", "recommend", "Select scenarios to learn from."),
}


@click.group(cls=LazyGroup, table=_COMMANDS)
def sera() -> None:
    """Learn from the failures that were recorded."""
