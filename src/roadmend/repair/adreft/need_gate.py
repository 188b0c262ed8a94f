"""Lets an intervention begin only where a model's need monitor foresees a collision, and says where it must be hard."""

import numpy as np
from numpy.typing import NDArray

from roadmend.repair.adreft.model import AdreftModel

NEVER = 1.0  # a bar that no score is above


class NeedGate:
    """Raises the bar of an intervention that has not begun and is not needed.

    Once it has begun, the score alone decides how long it lasts: of a moment in the middle of an intervention the need
    monitor has seen none. That the risk has stayed high while the ego braked it can tell, and then mild braking is not
    enough.

    Args:
        model: of ADReFT; without a need monitor every intervention is needed.
        threshold: risk above which it is; below 0 the model's own, at 0 always.
    """

    def __init__(self, model: AdreftModel, threshold: float) -> None:
        self._monitor = model.need
        self.threshold = 0.0 if self._monitor is None else self._monitor.threshold(threshold)
        self._pressing = model.configuration.pressing
        self._risk: float | None = None  # of this tick, where it was asked for already
        self._is_open = False

    def reset(self) -> None:
        """Begin an episode."""
        self._is_open = False

    def bar(self, score: float, threshold: float, bar: float, tokens: NDArray[np.float32]) -> tuple[float, str]:
        """What the score must be above at this tick, and why where that is more than it was.

        Args:
            score: how critical the scene is.
            threshold: at which an intervention has ended.
            bar: above which one is called for; not below the threshold.
            tokens: of the tick, shape (N, c).

        Raises:
            FloatingPointError: the risk is not finite.
        """
        self._risk = None
        if score <= threshold:
            self._is_open = False
        elif score > bar and not self._is_open and self._monitor is not None and self.threshold > 0.0:
            risk = self._risk = self._monitor.risk(tokens)
            if risk <= self.threshold:
                return NEVER, f"criticality {score:.3f}, but not needed: risk {risk:.3f} not above {self.threshold:.3f}"
            self._is_open = True
        return bar, ""

    def pressing_risk(self, tokens: NDArray[np.float32]) -> float | None:
        """The risk of a tick of an intervention where it is so high that nothing but full braking will do, else None.

        Args:
            tokens: of the tick that ``bar`` was asked about last, shape (N, c).

        Raises:
            FloatingPointError: the risk is not finite.
        """
        if self._monitor is None or self._pressing == 0.0:
            return None
        risk = self._monitor.risk(tokens) if self._risk is None else self._risk
        return risk if risk > self._pressing else None
