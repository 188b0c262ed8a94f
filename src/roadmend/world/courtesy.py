"""Nobody drives into a car that stands before them.

SUMO's drivers look along lanes and at points where lanes cross. A car that stands across their way inside a junction
can fall between the two, and they drive through it at walking pace. People do not, so here they brake for it.
"""

import math

import libsumo
import numpy as np
from numpy.typing import NDArray

from roadmend.core.geometry import corner_distance, fill_corners
from roadmend.core.jit import compiled
from roadmend.core.scene import EgoState, ObjectKind, ObjectList

Floats = NDArray[np.float64]

STANDING = 0.5  # [m/s] below which the ego counts as standing
_REACH = 14.0  # [m] between the centres within which drivers are looked at
_MARGIN = 0.4  # [m] that they keep
_LOOK_AHEAD = 1.6  # [s] that they look ahead
_STEPS = 8
_START_SPEED = 1.5  # [m/s] at least assumed: a driver who waits wants to start


@compiled
def _will_touch(
    x: float, y: float, yaw: float, speed: float, turn: float, length: float, width: float, ego: Floats
) -> bool:
    """Whether a vehicle that keeps its speed [m/s] and yaw rate [rad/s] comes to touch the ego's corners (4 x 2)."""
    corners = np.empty((4, 2), dtype=np.float64)
    fill_corners(corners, x, y, yaw, length, width)
    before = corner_distance(corners, ego)
    # At walking pace the measured yaw rate says little about the bend; keep its curvature instead.
    pace = max(speed, _START_SPEED)
    curvature = min(0.25, max(-0.25, turn / max(speed, 0.5)))
    step = pace * _LOOK_AHEAD / _STEPS
    for _ in range(_STEPS):
        yaw += 0.5 * curvature * step
        x += step * math.cos(yaw)
        y += step * math.sin(yaw)
        yaw += 0.5 * curvature * step
        fill_corners(corners, x, y, yaw, length, width)
        gap = corner_distance(corners, ego)
        if gap < _MARGIN and gap < before:
            return True
    return False


class Courtesy:
    """Makes drivers wait for a standing ego, and lets them go again."""

    def __init__(self) -> None:
        self._waiting: set[str] = set()

    def step(self, ego: EgoState, names: tuple[str, ...], everybody: ObjectList) -> None:
        """Look at everybody once; ``names`` are SUMO's, in the order of the list."""
        if ego.speed >= STANDING:
            if self._waiting:
                self._release(self._waiting & set(names))
            return
        corners = np.empty((4, 2))
        fill_corners(corners, ego.x, ego.y, ego.yaw, ego.length, ego.width)
        wait: set[str] = set()
        near = np.hypot(everybody.x - ego.x, everybody.y - ego.y) < _REACH
        for index in np.flatnonzero(near & (everybody.kind != ObjectKind.PEDESTRIAN)):
            body = (everybody.length[index], everybody.width[index])
            motion = (everybody.speed[index], everybody.yaw_rate[index])
            if _will_touch(everybody.x[index], everybody.y[index], everybody.yaw[index], *motion, *body, corners):
                wait.add(names[index])
        for name in wait - self._waiting:
            libsumo.vehicle.setSpeed(name, 0.0)
        self._release((self._waiting - wait) & set(names))
        self._waiting = wait

    def _release(self, names: set[str]) -> None:
        for name in sorted(names):
            libsumo.vehicle.setSpeed(name, -1.0)
        self._waiting -= names
