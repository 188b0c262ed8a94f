"""``roadmend bag``: what can be done with recordings."""

import click

from roadmend.cli.lazy import LazyGroup, Table

_COMMANDS: Table = {
    "plot": ("roadmend.cli.bag_plot", "plot", "Draw its time line, with the scene at one moment."),
    "shadow": ("roadmend.cli.bag_shadow", "shadow", "Ask another repair method what it would have done at every tick."),
    "resimulate": ("roadmend.cli.bag_resimulate", "resimulate", "Drive a bag's scenario again with another method."),
}


@click.group(cls=LazyGroup, table=_COMMANDS)
def bag() -> None:
    """Look into recordings."""
