"""A trained model that decides otherwise: another threshold, other rules of holding on and letting go; the same networks."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from roadmend.core.errors import InputError
from roadmend.core.settings import check_settings
from roadmend.networks.checkpoint import load_checkpoint
from roadmend.repair.adreft.configuration import Deciding, ModelConfiguration, read_configuration
from roadmend.repair.adreft.model import KIND
from roadmend.training.adreft.successor import save_successor

_FIXED = ("monitor", "adapter")  # shapes of networks


def adjust(model: Path, out: Path, threshold: float | None, changes: Mapping[str, Any], command: str) -> str:
    """Write the model anew; its header names what it was made from, and how. Returns the new file's digest.

    Args:
        model: of ADReFT.
        out: the new file.
        threshold: above which it steps in, 0 .. 1; None leaves it as it is.
        changes: of ``Deciding``, by name.
        command: that asked for it, without places on this machine.

    Raises:
        InputError: the model cannot be read, the new file not written, or a change is none or out of range.
    """
    checkpoint = load_checkpoint(model, KIND)
    configuration = read_configuration(str(model), checkpoint.header)
    before = configuration.model_dump(mode="json")
    known = sorted({*Deciding.model_fields} - {*_FIXED})
    for name in changes:
        if name not in known:
            raise InputError("--set", f"there is no {name!r}", f"choose from {', '.join(known)}")
    changed = check_settings({**before, **changes}, ModelConfiguration, "--set", "see config/training/adreft.yaml")
    foresees = configuration.weighing is not None
    if foresees != (changed.weighing is not None):
        what = "foresees collisions, which have prices" if foresees else "gives values, which have no prices"
        raise InputError("--set", f"weighing: the adapter of {model.name} {what}", "leave it as it is")
    if threshold is not None and not 0.0 <= threshold <= 1.0:
        raise InputError("--threshold", f"{threshold:g} is out of range", "give one from 0 to 1")
    return save_successor(
        out,
        checkpoint,
        checkpoint.tensors,
        changed,
        threshold=checkpoint.header["threshold"] if threshold is None else threshold,
        adjusted={"command": command, "metrics_are_of": checkpoint.digest},
    )
