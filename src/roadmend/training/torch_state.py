"""Weights of networks and the state of optimizers as plain arrays, so that training can go on later as if it had never stopped."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import nn
from torch.optim import Optimizer


def tensors_of(module: nn.Module, prefix: str = "") -> dict[str, NDArray[Any]]:
    """Copies of a module's parameters by name."""
    return {prefix + name: value.detach().cpu().numpy().copy() for name, value in module.state_dict().items()}


def load_tensors(module: nn.Module, tensors: Mapping[str, NDArray[Any]], prefix: str = "") -> None:
    """Give a module the parameters that lie under a prefix.

    Raises:
        RuntimeError: names or shapes do not fit.
    """
    module.load_state_dict(
        {
            name.removeprefix(prefix): torch.from_numpy(np.array(value))
            for name, value in tensors.items()
            if name.startswith(prefix)
        }
    )


def optimizer_tensors(optimizer: Optimizer, prefix: str) -> dict[str, NDArray[Any]]:
    """Copies of all that an optimizer remembers of its parameters."""
    return {
        f"{prefix}{number}.{name}": value.detach().cpu().numpy().copy()
        for number, memory in optimizer.state_dict()["state"].items()
        for name, value in memory.items()
    }


def load_optimizer(optimizer: Optimizer, tensors: Mapping[str, NDArray[Any]], prefix: str) -> None:
    """Give it back to an optimizer of the same parameters; settings such as the learning rate stay as they are."""
    state: dict[int, dict[str, Any]] = {}
    for name, value in tensors.items():
        if name.startswith(prefix):
            number, _, kind = name.removeprefix(prefix).partition(".")
            shape = () if kind == "step" else value.shape  # a file holds no scalars
            state.setdefault(int(number), {})[kind] = torch.from_numpy(np.array(value).reshape(shape))
    optimizer.load_state_dict({"state": state, "param_groups": optimizer.state_dict()["param_groups"]})
