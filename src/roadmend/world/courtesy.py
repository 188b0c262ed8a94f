"""Nobody drives into a car that stands before them.

SUMO's drivers look along lanes and at points where lanes cross. A car that stands across their way inside a junction
can fall between the two, and they drive through it at walking pace. People do not, so here they brake for it.
"""

import math
from collections.abc import Collection, Mapping
from types import MappingProxyType

import libsumo
import numpy as np
from numpy.typing import NDArray

from roadmend.core.geometry import Outline, corner_distance, fill_corners, fill_outline
from roadmend.core.jit import compiled
from roadmend.core.scene import EgoState, ObjectKind, ObjectList, Objects

Floats = NDArray[np.float64]

PEDESTRIAN = int(ObjectKind.PEDESTRIAN)
STANDING = 0.5  # [m/s] below which the ego counts as standing
_REACH = 14.0  # [m] between the centres within which drivers are looked at
_MARGIN = 0.4  # [m] that they keep
_LOOK_AHEAD = 1.6  # [s] that they look ahead
_STEPS = 8
_START_SPEED = 1.5  # [m/s] at least assumed: a driver who waits wants to start
_BRAKING = 8.0  # [m/s^2] an emergency for who drives; SUMO's comfortable deceleration comes too late


@compiled
def _will_touch(other: Outline, ego: Floats) -> bool:
    """Whether a vehicle that keeps its speed and yaw rate comes to touch the ego's corners (4 x 2)."""
    x, y, yaw, speed = other.x, other.y, other.yaw, other.speed
    corners = np.empty((4, 2), dtype=np.float64)
    fill_outline(corners, other)
    before = corner_distance(corners, ego)
    # At walking pace the measured yaw rate says little about the bend; keep its curvature instead.
    pace = max(speed, _START_SPEED)
    curvature = min(0.25, max(-0.25, other.yaw_rate / max(speed, 0.5)))
    step = pace * _LOOK_AHEAD / _STEPS
    for _ in range(_STEPS):
        yaw += 0.5 * curvature * step
        x += step * math.cos(yaw)
        y += step * math.sin(yaw)
        yaw += 0.5 * curvature * step
        fill_corners(corners, x, y, yaw, other.length, other.width)
        gap = corner_distance(corners, ego)
        if gap < _MARGIN and gap < before:
            return True
    return False


@compiled
def _who_waits(ego: EgoState, others: Objects) -> NDArray[np.intp]:
    """Indices of those who would touch the ego if it stood and they drove on."""
    corners = np.empty((4, 2), dtype=np.float64)
    fill_outline(corners, ego)
    found = np.empty(others.shape[0], dtype=np.intp)
    count = 0
    for index in range(others.shape[0]):
        other = others[index]
        near = other.kind != PEDESTRIAN and math.hypot(other.x - ego.x, other.y - ego.y) < _REACH
        if near and _will_touch(other, corners):
            found[count] = index
            count += 1
    return found[:count]


def set_deceleration(vehicle: str, deceleration: float) -> None:
    """How hard a vehicle may brake [m/s2]; SUMO puts the type's speed factor back with it, which is not meant."""
    factor = libsumo.vehicle.getSpeedFactor(vehicle)
    libsumo.vehicle.setDecel(vehicle, deceleration)
    libsumo.vehicle.setSpeedFactor(vehicle, factor)


class Courtesy:
    """Makes drivers wait for a standing ego, and lets them go again."""

    def __init__(self) -> None:
        self._waiting: dict[str, float] = {}  # and their usual deceleration [m/s^2]

    @property
    def waiting(self) -> Collection[str]:
        """Names of those who wait."""
        return self._waiting.keys()

    def resume(self, name: str, deceleration: float) -> bool:
        """Whether a driver waits; once let go, that one brakes like this again [m/s2]."""
        if name not in self._waiting:
            return False
        self._waiting[name] = deceleration
        return True

    def step(
        self,
        ego: EgoState,
        names: tuple[str, ...],
        around: ObjectList,
        heedless: Collection[str] = (),
        held: Mapping[str, float] = MappingProxyType({}),
    ) -> None:
        """Look at everybody once.

        Args:
            ego: that stands or not.
            names: SUMO's, in the order of the list.
            around: everybody near.
            heedless: who brakes for nobody.
            held: [m/s] what a manoeuvre has somebody drive, who does so again once let go.
        """
        if ego.speed >= STANDING:
            if self._waiting:
                self._release([*self._waiting], names, held)
            return
        indices = _who_waits(ego, around.table)
        wait = {names[index] for index in indices if names[index] not in heedless}
        for name in sorted(wait - self._waiting.keys()):
            usual = self._waiting[name] = libsumo.vehicle.getDecel(name)
            set_deceleration(name, max(usual, _BRAKING))
            libsumo.vehicle.setSpeed(name, 0.0)
        if len(wait) < len(self._waiting):
            self._release(sorted(self._waiting.keys() - wait), names, held)

    def _release(self, drivers: list[str], there: tuple[str, ...], held: Mapping[str, float]) -> None:
        """Let drivers go on, and forget those who have left."""
        for name in drivers:
            usual = self._waiting.pop(name)
            if name in there:
                set_deceleration(name, usual)
                libsumo.vehicle.setSpeed(name, held.get(name, -1.0))
