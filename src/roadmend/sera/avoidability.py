"""When it was too late to brake: the ego brakes on its recorded path, everybody else drives as recorded."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from roadmend.core.command import Command
from roadmend.core.geometry import corner_distance, fill_corners
from roadmend.core.scene import EgoState
from roadmend.core.tick import INTERVAL, INTERVAL_NS
from roadmend.sera.track import Track
from roadmend.world.ego import STANDING, LongitudinalDynamics, VehicleParameters

Floats = NDArray[np.float64]

LOOK_BACK = 8.0  # [s] before contact that are searched
AFTER = 3.0  # [s] past the contact without braking, in which there must be none either
_FULL_BRAKE = Command(0.0, 1.0)


def last_avoidable(stamps: Sequence[int], egos: Sequence[EgoState], other: Track, friction: float) -> float | None:
    """How long before the contact full braking would last have kept the ego and the other apart.

    An estimate: the other does not react to the braking; what it does after the contact is taken to be constant
    motion, and whether the ego would have met somebody else is not asked.

    Args:
        stamps: of the ego's poses [ns], rising; the last is that of the contact.
        egos: its poses.
        other: whom it met.
        friction: of the road.

    Returns:
        [s]; None if braking at no moment of the last LOOK_BACK seconds would have.
    """
    end = stamps[-1]
    for index in range(len(stamps) - 2, -1, -1):
        if end - stamps[index] > LOOK_BACK * 1e9 + 1:
            break
        if _stays_clear(stamps[index], egos[index:], other, friction, end):
            return round((end - stamps[index]) * 1e-9, 2)
    return None


def _stays_clear(begin: int, egos: Sequence[EgoState], other: Track, friction: float, end: int) -> bool:
    path = _Path(egos)
    body = LongitudinalDynamics(VehicleParameters(), friction, egos[0].speed)
    own, their = np.empty((4, 2)), np.empty((4, 2))
    way, stamp, curvature = 0.0, begin, path.curvature
    while stamp <= end + AFTER * 1e9:
        pose = other.pose(stamp)
        if pose is not None:
            fill_corners(own, *path.pose(way), egos[0].length, egos[0].width)
            fill_corners(their, *pose, other.length, other.width)
            if corner_distance(own, their) <= 0.0:
                return False
        if body.speed < STANDING and stamp > end:
            break  # a standing ego is hit by others or not at all
        way += body.step(_FULL_BRAKE, INTERVAL, curvature)
        stamp += INTERVAL_NS
    return True


class _Path:
    """The ego's recorded way, straight on beyond its end."""

    def __init__(self, egos: Sequence[EgoState]) -> None:
        self._x = np.array([ego.x for ego in egos])
        self._y = np.array([ego.y for ego in egos])
        self._yaw = np.unwrap(np.array([ego.yaw for ego in egos]))
        self._s = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(self._x), np.diff(self._y)))])
        first = egos[0]
        self.curvature = abs(first.yaw_rate) / first.speed if first.speed > 1.0 else 0.0  # [1/m]

    def pose(self, way: float) -> tuple[float, float, float]:
        x, y = float(np.interp(way, self._s, self._x)), float(np.interp(way, self._s, self._y))
        yaw = float(np.interp(way, self._s, self._yaw))
        beyond = max(0.0, way - float(self._s[-1]))
        return x + beyond * math.cos(yaw), y + beyond * math.sin(yaw), yaw
