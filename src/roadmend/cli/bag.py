"""``roadmend bag``: what can be done with recordings."""

import click

from roadmend.cli.lazy import LazyGroup, Table

_COMMANDS: Table = {
    "plot": ("roadmend.cli.bag_plot", "plot", "Draw its time line, with the scene at one moment."),
}


@click.group(cls=LazyGroup, table=_COMMANDS)
def bag() -> None:
    """Look into recordings."""
