"""``roadmend train``: train the networks that ship with the project, or your own."""

import click

from roadmend.cli.lazy import LazyGroup, Table

_COMMANDS: Table = {}


@click.group(cls=LazyGroup, table=_COMMANDS)
def train() -> None:
    """Train a driving policy, a repair model or a rival's model.

    The first call sets torch up: its build for CUDA, of several gigabytes, unless a CPU build of the release in
    config/requirements/train.txt has been put into .venv with pip before. CUDA is used where it is there.
    """
