"""The change monitor: what would come of the lane change that the policy asks for, judged before it begins.

The paper repairs throttle and brake alone. A lane change into somebody's place cannot be braked away once it has begun,
while one that waits a second costs next to nothing. So beside the state monitor a second one looks at the ticks at which
the policy asks for a change, and the merger holds back what it judges too dangerous; the policy may ask again.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from roadmend.core.parameters import Parameters
from roadmend.networks.compiled_encoder import CompiledEncoder, CompiledHead, sigmoid
from roadmend.networks.shape import EncoderShape, HeadShape, Width

PREFIX = "change."  # of its tensors in a model's file


class ChangeConfiguration(Parameters):
    """What a change monitor is built from, and from which risk it holds back."""

    encoder: EncoderShape = Field(description="shape of its own scene encoder")
    head: tuple[Width, ...] = Field((64,), description="hidden widths of what judges the scene's state")
    threshold: float = Field(ge=0.0, le=1.0, description="risk above which a lane change is held back")
    horizon: float = Field(gt=0.0, le=60.0, description="seconds within which a collision counts as of the change")

    @property
    def head_shape(self) -> HeadShape:
        """One logit from the scene's state."""
        return HeadShape(inputs=self.encoder.hidden, hidden=self.head, outputs=1)


class ChangeMonitor:
    """Gives the risk of a lane change that begins now.

    Args:
        configuration: what it is built from.
        tensors: by the names of training, behind PREFIX.

    Raises:
        ValueError: a tensor is missing, has another shape or holds what is not finite.
    """

    def __init__(self, configuration: ChangeConfiguration, tensors: Mapping[str, NDArray[Any]]) -> None:
        self.configuration = configuration
        self._encoder = CompiledEncoder(configuration.encoder, tensors, f"{PREFIX}encoder.")
        self._head = CompiledHead(configuration.head_shape, tensors, f"{PREFIX}head.")

    def risk(self, tokens: NDArray[np.float32]) -> float:
        """Probability that the ego collides by its own fault within the horizon, 0 .. 1, if the change begins now.

        Args:
            tokens: of the tick at which the policy asks, shape (N, c).
        """
        return sigmoid(float(self._head.apply(self._encoder.encode(tokens))[0]))

    @property
    def attention(self) -> NDArray[np.float32]:
        """How much the risk drew from each token of the last call, shape (N,)."""
        return self._encoder.attention
