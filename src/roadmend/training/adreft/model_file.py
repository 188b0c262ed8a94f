"""Writes model files of ADReFT."""

import hashlib
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from roadmend.networks.checkpoint import save_checkpoint
from roadmend.repair.adreft.configuration import ModelConfiguration
from roadmend.repair.adreft.model import KIND
from roadmend.training.closed_loop import EpisodeCase


def save_model(
    path: Path, model: ModelConfiguration, tensors: Mapping[str, NDArray[Any]], threshold: float, **header: Any
) -> str:
    """Write a model of ADReFT; ``header`` adds to or replaces what every model's header has. Returns its digest.

    Raises:
        InputError: the place cannot be written.
    """
    configuration = {"model": model.model_dump(mode="json"), **header.pop("configuration", {})}
    whole = {"kind": KIND, "threshold": threshold, "data_digest": "", "metrics": {}, "ancestry": [], **header}
    return save_checkpoint(path, tensors, {**whole, "configuration": configuration})


def digest_of_cases(cases: Sequence[EpisodeCase]) -> str:
    """SHA-256 over the names and trajectories of cases, hexadecimal."""
    return hashlib.sha256(json.dumps([[case.name, case.digest] for case in cases]).encode()).hexdigest()
