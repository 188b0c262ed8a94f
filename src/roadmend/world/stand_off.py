"""No stand-off lasts for ever: who stands across the ego's way in a junction, or waits for it, is taken off in the end.

In SUMO two vehicles whose paths meet inside a junction can stand before each other for good; people would back up or
steer around. SUMO's own remedies (time-to-teleport, ignore-junction-blocker) know nothing of a vehicle that is driven
from outside, as the ego is.
"""

import math
from collections.abc import Callable, Collection

import libsumo
import numpy as np

from roadmend.core.geometry import corner_distance, fill_corners, fill_outline, wrap_angle
from roadmend.core.scene import EgoState, ObjectKind, ObjectList
from roadmend.world.courtesy import STANDING

PATIENCE = 8.0  # [s] that both must have stood
_CREEP = 1.5  # [m] that the ego may have moved meanwhile
_AHEAD = (1.0, 2.0, 4.0, 6.0, 8.0)  # [m] of the ego's way that are looked at
_MARGIN = 0.5  # [m] kept from the ego's way
_ALIKE = math.radians(30.0)  # between headings of a queue
_NEAR = 15.0  # [m] between the centres

Way = Callable[[float], tuple[float, float, float]]


class StandOff:
    """Finds those who have blocked the ego for too long."""

    def __init__(self, interval: float, fixed: Collection[str] = ()) -> None:
        """Start afresh; ``interval`` [s] is the time between ticks, ``fixed`` names what nobody can take off the road."""
        self._fixed = frozenset(fixed)
        self._patience = round(PATIENCE / interval)
        self._from = (math.inf, math.inf)  # where the ego was [m] when it last got on
        self._ego_ticks = 0  # since then
        self._stood: dict[str, int] = {}  # ticks that others have stood since then

    def step(
        self, ego: EgoState, way: Way, names: tuple[str, ...], around: ObjectList, waiting: Collection[str]
    ) -> list[str]:
        """Take those who block the ego off the road and say who they were.

        Args:
            ego: its state.
            way: pose (x, y [m], yaw [rad]) of the ego after so many metres of its route.
            names: SUMO's, in the order of ``around``.
            around: who is near.
            waiting: names of those who wait because the ego stands.
        """
        if math.hypot(ego.x - self._from[0], ego.y - self._from[1]) > _CREEP:
            self._from, self._ego_ticks = (ego.x, ego.y), 0
            self._stood.clear()
            return []
        self._ego_ticks += 1
        slow = (around.speed < STANDING) & (around.kind != int(ObjectKind.PEDESTRIAN))
        standing = {names[index]: int(index) for index in np.flatnonzero(slow) if names[index] not in self._fixed}
        self._stood = {name: self._stood.get(name, 0) + 1 for name in standing}
        if self._ego_ticks < self._patience:
            return []
        patient = [name for name, ticks in self._stood.items() if ticks >= self._patience]
        found = [
            name
            for name in patient
            if _is_in_junction(name)
            and not _queues(ego, around, standing[name])
            and (name in waiting or _blocks(ego, way, around, standing[name]))
        ]
        for name in found:
            libsumo.vehicle.remove(name)
            del self._stood[name]
        if found:
            self._ego_ticks = 0
        return found


def _blocks(ego: EgoState, way: Way, around: ObjectList, index: int) -> bool:
    blocker = around.table[index]
    if math.hypot(blocker["x"] - ego.x, blocker["y"] - ego.y) > _NEAR:
        return False
    other, own = np.empty((4, 2)), np.empty((4, 2))
    fill_outline(other, blocker)
    for distance in _AHEAD:
        fill_corners(own, *way(distance), ego.length, ego.width)
        if corner_distance(own, other) < _MARGIN:
            return True
    return False


def _queues(ego: EgoState, around: ObjectList, index: int) -> bool:
    """Whether somebody stands behind the ego, in its direction: the ego may wait at a light, and they with it."""
    other = around.table[index]
    dx, dy = float(other["x"]) - ego.x, float(other["y"]) - ego.y
    cosine, sine = math.cos(ego.yaw), math.sin(ego.yaw)
    along, across = cosine * dx + sine * dy, cosine * dy - sine * dx
    is_alike = abs(wrap_angle(float(other["yaw"]) - ego.yaw)) < _ALIKE
    return along < -0.5 * ego.length and abs(across) < ego.width and is_alike


def _is_in_junction(name: str) -> bool:
    """Whether the front or the back of a vehicle is in a junction; a queue on a road is none of our business."""
    lane = libsumo.vehicle.getLaneID(name)
    if lane.startswith(":"):
        return True
    return bool(libsumo.vehicle.getLanePosition(name) < libsumo.vehicle.getLength(name))
