"""Risk monitors: networks beside the state monitor that are asked at few ticks, each with a scene encoder of its own.

The *need monitor* is asked where the state monitor would have an intervention begin: does the drive end badly if nobody
steps in now? The state monitor is taught the last seconds before a collision, mostly on cases that a search has found; of
ordinary near misses it is as sure as of collisions. The need monitor is taught on those moments alone, and on what came
of them.

The *change monitor* is asked where the policy wants to change lanes: what comes of it if the change begins now? The paper
repairs throttle and brake alone (ADReFT section 3.1.3). A lane change into somebody's place cannot be braked away once it
has begun, while one that waits a second costs next to nothing.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from roadmend.core.parameters import Parameters
from roadmend.networks.compiled_encoder import CompiledEncoder, CompiledHead, sigmoid
from roadmend.networks.shape import EncoderShape, HeadShape, Width
from roadmend.repair.adreft.history import ATTRIBUTES


class RiskConfiguration(Parameters):
    """What a risk monitor is built from, and which risk is too much."""

    encoder: EncoderShape = Field(description="shape of its own scene encoder")
    head: tuple[Width, ...] = Field((64,), description="hidden widths of what judges the scene's state")
    threshold: float = Field(ge=0.0, le=1.0, description="risk above which it speaks up")
    horizon: float = Field(gt=0.0, le=60.0, description="seconds within which a collision counts")
    history: bool = Field(default=False, description="its tokens tell of the last second and of the drive so far, too")

    def attributes(self, of_tick: int) -> int:
        """Attributes that its tokens must have where those of a tick have so many."""
        return of_tick + (ATTRIBUTES if self.history else 0)

    @property
    def head_shape(self) -> HeadShape:
        """One logit from the scene's state."""
        return HeadShape(inputs=self.encoder.hidden, hidden=self.head, outputs=1)


class RiskMonitor:
    """Gives the risk of going on as the policy wants at one tick.

    Args:
        configuration: what it is built from.
        tensors: of a model's file.
        prefix: of its own among them, "need." or "change.".

    Raises:
        ValueError: a tensor is missing, has another shape or holds what is not finite.
    """

    def __init__(self, configuration: RiskConfiguration, tensors: Mapping[str, NDArray[Any]], prefix: str) -> None:
        self.configuration = configuration
        self._encoder = CompiledEncoder(configuration.encoder, tensors, f"{prefix}encoder.")
        self._head = CompiledHead(configuration.head_shape, tensors, f"{prefix}head.")

    def risk(self, tokens: NDArray[np.float32]) -> float:
        """Probability that the ego collides by its own fault within the horizon, 0 .. 1.

        Args:
            tokens: of the tick, shape (N, c), with the columns of its history where it takes them.

        Raises:
            FloatingPointError: it is not finite.
        """
        risk = sigmoid(float(self._head.apply(self._encoder.encode(tokens))[0]))
        if not np.isfinite(risk):
            raise FloatingPointError("a risk is not finite")
        return risk

    def threshold(self, given: float) -> float:
        """Above which risk it speaks up: what was given, or below 0 its own."""
        return given if given >= 0.0 else self.configuration.threshold

    @property
    def attention(self) -> NDArray[np.float32]:
        """How much the risk drew from each token of the last call, shape (N,)."""
        return self._encoder.attention
