"""The networks of ADReFT in torch, for training, and the model files that are written of them."""

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from roadmend.core.errors import InputError
from roadmend.networks.checkpoint import Checkpoint, load_checkpoint, save_checkpoint
from roadmend.networks.encoder import Head, SceneEncoder
from roadmend.repair.adreft.configuration import ModelConfiguration, read_configuration
from roadmend.repair.adreft.model import KIND, AdreftModel
from roadmend.training.closed_loop import EpisodeCase

_PARTS = ("encoder", "monitor", "adapter")  # of an AdreftNetwork


class AdreftNetwork(nn.Module):
    """State encoder, state monitor and decision adapter (ADReFT section 3.1)."""

    def __init__(self, configuration: ModelConfiguration) -> None:
        super().__init__()
        self.encoder = SceneEncoder(configuration.encoder)
        self.monitor = Head(configuration.monitor_shape)
        self.adapter = Head(configuration.adapter_shape)

    def forward(self, tokens: Tensor, mask: Tensor, action: Tensor) -> tuple[Tensor, Tensor]:
        """Logit of the monitor, shape (B,), and values of the adapter, shape (B, actions).

        Args:
            tokens: shape (B, N, c).
            mask: shape (B, N), true where there is a token.
            action: the policy's throttle - brake, shape (B,).
        """
        state = self.encoder(tokens, mask)
        return self.judge(state, action), self.adapter(state)

    def judge(self, state: Tensor, action: Tensor) -> Tensor:
        """Logit of the monitor, shape (B,), from states of shape (B, H) and the policy's actions of shape (B,)."""
        logit: Tensor = self.monitor(torch.cat([state, action[:, None]], dim=1))[:, 0]
        return logit


def networks_of(tensors: Mapping[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    """The tensors of a model's file that AdreftNetwork takes: all but those of risk monitors."""
    return {name: value for name, value in tensors.items() if name.partition(".")[0] in _PARTS}


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


def load_start(path: Path, wanted: ModelConfiguration) -> Checkpoint:
    """A model of ADReFT to begin a training with, without its risk monitors: they are of the model as it was.

    Raises:
        InputError: it cannot be read, or has other networks than are wanted.
    """
    checkpoint = load_checkpoint(path, KIND)
    AdreftModel.of(checkpoint, str(path))  # whatever does not fit is said here
    kept = read_configuration(str(path), checkpoint.header)
    if (kept.tokenizer, kept.encoder, kept.monitor_shape, kept.adapter_shape) != (
        wanted.tokenizer,
        wanted.encoder,
        wanted.monitor_shape,
        wanted.adapter_shape,
    ):
        mend = "give a model of the same configuration, or begin without one"
        raise InputError(str(path), "has other networks than the configuration asks for", mend)
    return replace(checkpoint, tensors=networks_of(checkpoint.tensors))


def digest_of_cases(cases: Sequence[EpisodeCase]) -> str:
    """SHA-256 over the names and trajectories of cases, hexadecimal."""
    return hashlib.sha256(json.dumps([[case.name, case.digest] for case in cases]).encode()).hexdigest()


def digest_of_tensors(tensors: Mapping[str, NDArray[Any]]) -> str:
    """SHA-256 over the names, shapes and values of tensors, hexadecimal."""
    value = hashlib.sha256()
    for name in sorted(tensors):
        value.update(f"{name}{tensors[name].shape}".encode())
        value.update(np.ascontiguousarray(tensors[name]).tobytes())
    return value.hexdigest()
