"""A model of ADReFT made from another one, with its data, metrics and ancestry."""

from pathlib import Path
from typing import Any

from roadmend.networks.checkpoint import Checkpoint, Tensors, save_checkpoint
from roadmend.repair.adreft.configuration import ModelConfiguration
from roadmend.repair.adreft.model import AdreftModel


def save_successor(
    out: Path, parent: Checkpoint, tensors: Tensors, configuration: ModelConfiguration, **header: object
) -> str:
    """Write a model that was made from another one. Returns the new file's digest.

    Args:
        out: the new file.
        parent: what it was made from.
        tensors: of the new model, by name.
        configuration: of the new model.
        header: what is said of it besides, in the place of what is said of the parent; JSON.

    Raises:
        InputError: the file cannot be written, or the tensors do not fit the configuration.
    """
    whole: dict[str, Any] = {
        **parent.header,
        "configuration": {**parent.header["configuration"], "model": configuration.model_dump(mode="json")},
        "ancestry": [parent.digest, *parent.header["ancestry"]],
        **header,
    }
    AdreftModel.of(Checkpoint(dict(tensors), whole, ""), str(out))  # before it is written over what may be the parent
    return save_checkpoint(out, tensors, whole)
