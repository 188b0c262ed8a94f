"""What a policy decides: a command for the actuators and the trajectory behind it."""

import math
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Command:
    """Throttle and brake for one tick, each in [0, 1], never both above zero."""

    throttle: float
    brake: float
    change_lane: bool = False  # begin the route's next lane change if the ego is inside its window

    @property
    def action(self) -> float:
        """The command as one number a = throttle - brake in [-1, 1] (ADReFT section 3.1)."""
        return self.throttle - self.brake

    @classmethod
    def from_action(cls, action: float, *, change_lane: bool = False) -> Self:
        """The command whose action is ``action``, which must lie in [-1, 1]."""
        return cls(max(action, 0.0), max(-action, 0.0), change_lane)

    @property
    def fault(self) -> str:
        """Why this is not a valid command, or an empty string."""
        if not (math.isfinite(self.throttle) and math.isfinite(self.brake)):
            return "throttle or brake is not finite"
        if not 0.0 <= self.throttle <= 1.0:
            return f"throttle {self.throttle:g} is outside 0..1"
        if not 0.0 <= self.brake <= 1.0:
            return f"brake {self.brake:g} is outside 0..1"
        if self.throttle > 0.0 and self.brake > 0.0:
            return "throttle and brake are both pressed"
        return ""


@dataclass(frozen=True, slots=True, eq=False)
class Trajectory:
    """Planned motion of the ego's centre, shape (P,) each; point i is (i + 1) * interval seconds after it was planned.

    That is the tick at hand, but for a policy that plans less often and hands its last plan out once more meanwhile.
    """

    interval: float  # [s]
    x: Floats  # [m]
    y: Floats  # [m]
    yaw: Floats  # [rad]
    speed: Floats  # [m/s]
    behaviour: str = ""  # what the policy is doing, in one word

    def __len__(self) -> int:
        return len(self.x)

    @classmethod
    def empty(cls) -> Self:
        """A plan without points."""
        none = np.empty(0, dtype=np.float64)
        return cls(1.0, none, none, none, none)


@dataclass(frozen=True, slots=True, eq=False)
class Decision:
    """A policy's answer to a scene."""

    command: Command
    trajectory: Trajectory
