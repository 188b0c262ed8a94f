"""A model of ADReFT in plain torch, one operation after another: what the compiled one is measured against."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from roadmend.repair.adreft.configuration import ModelConfiguration
from roadmend.repair.adreft.model import AdreftModel
from roadmend.training.adreft.network import AdreftNetwork, networks_of
from roadmend.training.torch_state import load_tensors


class EagerAdreftModel(AdreftModel):
    """Takes the place of AdreftModel in the repair method; it runs on one core. States are tensors of shape (1, H).

    The weights that the paper's text gives to tokens are not there: torch's attention keeps them to itself, and
    ``attention`` is all zeros.
    """

    def __init__(
        self, configuration: ModelConfiguration, tensors: Mapping[str, NDArray[Any]], threshold: float, digest: str = ""
    ) -> None:
        super().__init__(configuration, tensors, threshold, digest)
        torch.set_num_threads(1)
        self._network = AdreftNetwork(configuration).eval()
        load_tensors(self._network, networks_of(tensors))
        self._count = 0

    @torch.inference_mode()
    def encode(self, tokens: NDArray[np.float32]) -> Any:
        """x_c of tokens of shape (N, c)."""
        self._count = len(tokens)
        mask = torch.ones(1, self._count, dtype=torch.bool)
        return self._network.encoder(torch.from_numpy(tokens)[None], mask)

    @property
    def attention(self) -> NDArray[np.float32]:
        """Zeros, shape (N,)."""
        return np.zeros(self._count, dtype=np.float32)

    @torch.inference_mode()
    def score(self, state: Any, action: float) -> float:
        """y_safe, 0 safe .. 1 critical."""
        logit = self._network.judge(state, torch.tensor([action], dtype=torch.float32))
        return float(torch.sigmoid(logit)[0])

    @torch.inference_mode()
    def values(self, state: Any, action: float) -> NDArray[np.float32]:
        """Q of every action, shape (actions,)."""
        return self._valued(self._network.adapter(state)[0].numpy(), action)
