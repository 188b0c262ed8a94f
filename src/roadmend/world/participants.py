"""Reads everybody but the ego out of SUMO, in the project's own frame and units."""

import math
from dataclasses import dataclass

import libsumo
import numpy as np
from numpy.typing import NDArray

from roadmend.core.geometry import outline_distances, wrap_angle
from roadmend.core.jit import compiled
from roadmend.core.scene import EgoState, ObjectKind, ObjectList
from roadmend.world.drivers import KINDS, PEDESTRIAN_LENGTH, PEDESTRIAN_WIDTH

Floats = NDArray[np.float64]

NEAR = 10.0  # [m] gap below which distances are exact


@compiled
def _to_map_frame(
    raw: Floats, lengths: Floats, previous_yaw: Floats, interval: float, x: Floats, y: Floats, yaw: Floats, turn: Floats
) -> None:
    """SUMO's front bumper and degrees clockwise from north -> centre and radians counter-clockwise from east."""
    for index in range(raw.shape[0]):
        heading = wrap_angle(math.radians(90.0 - raw[index, 2]))
        yaw[index] = heading
        x[index] = raw[index, 0] - 0.5 * lengths[index] * math.cos(heading)
        y[index] = raw[index, 1] - 0.5 * lengths[index] * math.sin(heading)
        before = previous_yaw[index]
        turn[index] = 0.0 if math.isnan(before) else wrap_angle(heading - before) / interval


@dataclass(frozen=True, slots=True)
class _Fixed:
    """What does not change about a participant while it is there."""

    number: int
    kind: int
    length: float  # [m]
    width: float  # [m]


@dataclass(frozen=True, slots=True)
class Observation:
    """Everybody at one tick."""

    objects: ObjectList  # those within the sensing range
    everybody: ObjectList  # in the order of ``names``
    names: tuple[str, ...]  # SUMO's names, in the order of ``distances``
    distances: Floats  # [m] of every participant's outline to the ego's; exact below NEAR


class Participants:
    """Numbers the participants of an episode and observes them tick by tick."""

    def __init__(self, ego_name: str, interval: float, sensing_range: float, *, with_persons: bool) -> None:
        self._ego_name = ego_name
        self._interval = interval
        self._range = sensing_range  # [m], may be infinite
        self._with_persons = with_persons
        self._fixed: dict[str, _Fixed] = {}
        self._names: tuple[str, ...] = ()
        self._static = (np.empty(0, np.uint32), np.empty(0, np.uint8), np.empty(0), np.empty(0))
        self._yaw = np.empty(0)

    @property
    def present(self) -> tuple[str, ...]:
        """SUMO's names of those who were there at the last tick."""
        return self._names

    def number_of(self, name: str) -> int:
        """The object id of a participant."""
        return self._fixed[name].number

    def is_pedestrian(self, name: str) -> bool:
        """Whether a participant is on foot."""
        return self._fixed[name].kind == ObjectKind.PEDESTRIAN

    def observe(self, ego: EgoState) -> Observation:
        """Read everybody's state as it is after the last SUMO step."""
        vehicle = libsumo.vehicle
        position, angle, speed, acceleration = (
            vehicle.getPosition, vehicle.getAngle, vehicle.getSpeed, vehicle.getAcceleration,
        )  # fmt: skip
        names = [name for name in vehicle.getIDList() if name != self._ego_name]
        rows = [(*position(name), angle(name), speed(name), acceleration(name)) for name in names]
        if self._with_persons:
            person = libsumo.person
            for name in person.getIDList():
                names.append(name)
                rows.append((*person.getPosition(name), person.getAngle(name), person.getSpeed(name), 0.0))
        if tuple(names) != self._names:
            self._renew(tuple(names))
        raw = np.array(rows) if rows else np.empty((0, 5))
        number, kind, length, width = self._static
        count = len(names)
        x, y, yaw, turn = np.empty(count), np.empty(count), np.empty(count), np.empty(count)
        _to_map_frame(raw, length, self._yaw, self._interval, x, y, yaw, turn)
        self._yaw = yaw
        distances = outline_distances(ego.x, ego.y, ego.yaw, ego.length, ego.width, x, y, yaw, length, width, NEAR)
        objects = ObjectList(number, kind, x, y, yaw, raw[:, 3].copy(), raw[:, 4].copy(), turn, length, width)
        seen = objects
        if math.isfinite(self._range):
            near = np.hypot(x - ego.x, y - ego.y) <= self._range
            if not near.all():
                seen = objects.select(near)
        return Observation(seen, objects, self._names, distances)

    def _renew(self, names: tuple[str, ...]) -> None:
        """Somebody came or went: look up the newcomers and carry the rest over."""
        before = dict(zip(self._names, self._yaw, strict=True))
        for name in names:
            if name not in self._fixed:
                self._fixed[name] = self._look_up(name)
        fixed = [self._fixed[name] for name in names]
        self._static = (
            np.array([entry.number for entry in fixed], dtype=np.uint32),
            np.array([entry.kind for entry in fixed], dtype=np.uint8),
            np.array([entry.length for entry in fixed], dtype=np.float64),
            np.array([entry.width for entry in fixed], dtype=np.float64),
        )
        self._yaw = np.array([before.get(name, math.nan) for name in names], dtype=np.float64)
        self._names = names

    def _look_up(self, name: str) -> _Fixed:
        number = len(self._fixed) + 1
        if self._with_persons and name in libsumo.person.getIDList():
            # A person's outline is a body, not the point that SUMO walks; its position is its centre.
            return _Fixed(number, int(ObjectKind.PEDESTRIAN), PEDESTRIAN_LENGTH, PEDESTRIAN_WIDTH)
        kind = KINDS.get(libsumo.vehicle.getVehicleClass(name), ObjectKind.UNKNOWN)
        return _Fixed(number, int(kind), libsumo.vehicle.getLength(name), libsumo.vehicle.getWidth(name))
