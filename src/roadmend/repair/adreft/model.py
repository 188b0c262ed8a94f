"""A trained model of ADReFT as it runs: compiled, without torch (ADReFT sections 3.1.1 to 3.1.3)."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from roadmend.core.errors import InputError
from roadmend.core.scene import Scene
from roadmend.networks.checkpoint import Checkpoint, load_checkpoint
from roadmend.networks.compiled_encoder import CompiledEncoder, CompiledHead, sigmoid
from roadmend.repair.adreft.configuration import ModelConfiguration, read_configuration
from roadmend.repair.adreft.rear import time_to_rear
from roadmend.repair.adreft.registry import make_tokenizer
from roadmend.repair.adreft.risk_monitor import RiskMonitor
from roadmend.repair.adreft.tokenizer import Tokenizer
from roadmend.repair.adreft.weighing import gain_of, weigh

Floats = NDArray[np.float32]
Tensors = Mapping[str, NDArray[Any]]

KIND = "adreft"


class AdreftModel:
    """State encoder, state monitor and decision adapter; perhaps monitors of need and of lane changes.

    Args:
        configuration: what it is built from.
        tensors: by the names that the networks have in training: "encoder.", "monitor.", "adapter.",
            "need." and "change.".
        threshold: lambda_safe.
        digest: of the file it comes from.

    Raises:
        ValueError: a tensor is missing, has another shape or holds what is not finite.
    """

    def __init__(self, configuration: ModelConfiguration, tensors: Tensors, threshold: float, digest: str = "") -> None:
        self.configuration = configuration
        self.threshold = threshold
        self.digest = digest
        self._encoder = CompiledEncoder(configuration.encoder, tensors, "encoder.")
        self._monitor = CompiledHead(configuration.monitor_shape, tensors, "monitor.")
        self._adapter = CompiledHead(configuration.adapter_shape, tensors, "adapter.")
        risks = {name: RiskMonitor(each, tensors, f"{name}.") for name, each in configuration.risks.items()}
        self.need, self.change = risks.get("need"), risks.get("change")
        self._seen = np.empty(configuration.encoder.hidden + 1, dtype=np.float32)

    @classmethod
    def load(cls, path: Path) -> Self:
        """Read a model's file.

        Raises:
            InputError: it is missing, damaged, no model of ADReFT, or does not fit this version of roadmend.
        """
        return cls.of(load_checkpoint(path, KIND), str(path))

    @classmethod
    def of(cls, checkpoint: Checkpoint, where: str) -> Self:
        """Build from what was read from a file.

        Raises:
            InputError: it does not fit this version of roadmend.
        """
        configuration = read_configuration(where, checkpoint.header)
        mend = "train the model again with this version of roadmend"
        tokenizer = make_tokenizer(configuration.tokenizer)
        if configuration.tokenizer_version != tokenizer.version:
            what = f"was trained on version {configuration.tokenizer_version} of the tokens '{tokenizer.name}'"
            raise InputError(where, f"{what}, this is version {tokenizer.version}", mend)
        if configuration.encoder.attributes != tokenizer.attributes:
            raise InputError(where, f"does not take the {tokenizer.attributes} attributes of '{tokenizer.name}'", mend)
        for name, each in configuration.risks.items():
            if each.history and not tokenizer.has_ego:
                what = f"its {name} monitor is told of the ego's history, for which '{tokenizer.name}' has no token"
                raise InputError(where, what, mend)
            wanted = each.attributes(tokenizer.attributes)
            if each.encoder.attributes != wanted:
                what = f"its {name} monitor does not take the {wanted} attributes that '{tokenizer.name}' leads to"
                raise InputError(where, what, mend)
        threshold = checkpoint.header.get("threshold")
        if not isinstance(threshold, float) or not math.isfinite(threshold):
            raise InputError(where, "has no threshold", mend)
        try:
            return cls(configuration, checkpoint.tensors, threshold, checkpoint.digest)
        except ValueError as error:
            raise InputError(where, str(error), mend) from None

    def tokenizer(self) -> Tokenizer:
        """A tokenizer of the kind that the model was trained with."""
        return make_tokenizer(self.configuration.tokenizer)

    def encode(self, tokens: Floats) -> Floats:
        """x_c, the scene's state, shape (H,), from tokens of shape (N, c)."""
        return self._encoder.encode(tokens)

    @property
    def attention(self) -> Floats:
        """How much the state drew from each token of the last call of ``encode``, shape (N,)."""
        return self._encoder.attention

    def score(self, state: Floats, action: float) -> float:
        """y_safe: how critical the scene is under the policy's action (throttle - brake), 0 safe .. 1 critical."""
        self._seen[:-1] = state
        self._seen[-1] = action
        return sigmoid(float(self._monitor.apply(self._seen)[0]))

    def given(self, state: Floats) -> Floats:
        """What the adapter says of a state, before prices make values of it: values, or logits, shape (outputs,)."""
        return self._adapter.apply(state)

    def values(self, state: Floats, action: float) -> Floats:
        """Q of every action of the repair action space, shape (actions,), where the policy asks for ``action``."""
        return self._valued(self._adapter.apply(state), action)

    def due(self, values: Floats, action: float, scene: Scene) -> float:
        """How due an intervention is by what it is worth: 0 not at all, the threshold at ``weighing.gain``, at most 1.

        The monitor is taught the last seconds before a collision; what pays can be due long before. It is the larger of
        its score and this that is compared with the threshold. Somebody who closes in from behind has no such time:
        what a trial taught of braking, it mostly taught where nobody did.

        Args:
            values: of every action, shape (actions,).
            action: the policy's throttle - brake.
            scene: what there is around the ego.
        """
        prices = self.configuration.weighing
        if prices is None or not prices.gain:
            return 0.0
        worth = max(0.0, gain_of(values, action))
        if worth > prices.gain and prices.rear and time_to_rear(scene) < prices.rear:
            return 0.0
        return min(1.0, self.threshold * worth / prices.gain)

    def worth(self, values: Floats, action: float, chosen: int) -> float | None:
        """By how much a choice is judged better than leaving the policy alone, in prices of a collision.

        None where the adapter foresees no collisions (the paper's): its values have no price to be measured in.

        Args:
            values: of every action, shape (actions,).
            action: the policy's throttle - brake.
            chosen: index of the action.
        """
        prices = self.configuration.weighing
        return None if prices is None else gain_of(values, action, chosen) / prices.collision

    def _valued(self, given: Floats, action: float) -> Floats:
        """Values from what the adapter gives."""
        prices = self.configuration.weighing
        return given if prices is None else weigh(given, action, prices)
