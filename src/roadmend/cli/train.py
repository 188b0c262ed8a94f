"""``roadmend train``: train the networks that ship with the project, or your own."""

import click

from roadmend.cli.lazy import LazyGroup, Table

_COMMANDS: Table = {
    "policy": ("roadmend.cli.train_policy", "policy", "A neural driving policy, by imitation of the expert."),
    "adreft": ("roadmend.cli.train_adreft", "adreft", "ADReFT for one policy, from its corpus."),
    "self-oracle": ("roadmend.cli.train_rivals", "self_oracle", "The autoencoder of the rival ModelRepair."),
    "rivals": ("roadmend.cli.train_rivals", "rivals", "The rivals' best settings on the validation split."),
}


@click.group(cls=LazyGroup, table=_COMMANDS)
def train() -> None:
    """Train a driving policy, a repair model or a rival's model.

    The first call sets torch up: its build for CUDA, of several gigabytes, unless a CPU build of the release in
    config/requirements/train.txt has been put into .venv with pip before. CUDA is used where it is there.
    """
