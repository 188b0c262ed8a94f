"""The networks of ADReFT in torch, for training."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from roadmend.networks.encoder import Head, SceneEncoder
from roadmend.repair.adreft.configuration import ModelConfiguration


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
