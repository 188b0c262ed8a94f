"""``roadmend bag``: what was recorded, looked into, mended and compared."""

import click

from roadmend.cli.lazy import LazyGroup, Table

_COMMANDS: Table = {
    "info": ("roadmend.cli.bag_info", "bag_info", "Topics, rates, gaps, outcome, interventions; is it complete?"),
    "recover": ("roadmend.cli.bag_recover", "bag_recover", "What a cut or damaged bag still holds, as a new bag."),
    "diff": ("roadmend.cli.bag_diff", "bag_diff", "Two bags, tick by tick."),
    "convert": ("roadmend.cli.bag_convert", "bag_convert", "From mcap to sqlite3 and back."),
    "plot": ("roadmend.cli.bag_plot", "plot", "Draw its time line, with the scene at one moment."),
    "shadow": ("roadmend.cli.bag_shadow", "shadow", "Ask another repair method what it would have done at every tick."),
    "resimulate": ("roadmend.cli.bag_resimulate", "resimulate", "Drive a bag's scenario again with another method."),
}


@click.group(cls=LazyGroup, table=_COMMANDS)
def bag() -> None:
    """Look into bags, mend them, compare them.

    BAG is a bag's folder, its metadata.yaml, or an .mcap file by itself.
    """
