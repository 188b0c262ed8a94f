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
AROUND = 40.0  # [m] centre to centre; everybody within is watched for contact, seen or not


@compiled
def _measure(
    raw: Floats,
    lengths: Floats,
    widths: Floats,
    before: Floats,
    interval: float,
    ego_x: float,
    ego_y: float,
    ego_yaw: float,
    ego_length: float,
    ego_width: float,
    out: Floats,
) -> float:
    """SUMO's rows into columns of the project's frame; returns the smallest distance to the ego [m].

    ``raw`` (N x 4) holds front bumper x and y [m], degrees clockwise from north and speed [m/s]. ``out`` (7 x N)
    receives centre x and y [m], yaw [rad], speed, acceleration [m/s2], yaw rate [rad/s] and distance [m]; ``before``
    (2 x N) holds yaw and speed of the last tick, NaN for newcomers.
    """
    for index in range(raw.shape[0]):
        heading = wrap_angle(math.radians(90.0 - raw[index, 2]))
        out[0, index] = raw[index, 0] - 0.5 * lengths[index] * math.cos(heading)
        out[1, index] = raw[index, 1] - 0.5 * lengths[index] * math.sin(heading)
        out[2, index] = heading
        out[3, index] = raw[index, 3]
        is_new = math.isnan(before[0, index])
        out[4, index] = 0.0 if is_new else (raw[index, 3] - before[1, index]) / interval
        out[5, index] = 0.0 if is_new else wrap_angle(heading - before[0, index]) / interval
    distances = outline_distances(
        ego_x, ego_y, ego_yaw, ego_length, ego_width, out[0], out[1], out[2], lengths, widths, NEAR
    )
    nearest = np.inf
    for index in range(raw.shape[0]):
        out[6, index] = distances[index]
        nearest = min(nearest, distances[index])
    return nearest


@dataclass(frozen=True, slots=True)
class _Fixed:
    """What does not change about a participant while it is there."""

    number: int
    kind: int
    length: float  # [m]
    width: float  # [m]


@dataclass(frozen=True, slots=True)
class Observation:
    """Everybody around the ego at one tick."""

    objects: ObjectList  # those within the sensing range
    around: ObjectList  # those within the sensing range or AROUND, in the order of ``names``
    names: tuple[str, ...]  # SUMO's
    distances: Floats  # [m] of their outlines to the ego's; exact below NEAR
    nearest: float  # [m] the smallest of these, infinite if there is nobody


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
        self._before = np.empty((2, 0))  # yaw [rad] and speed [m/s] at the last tick

    def number_of(self, name: str) -> int:
        """The object id of a participant."""
        return self._fixed[name].number

    def is_pedestrian(self, name: str) -> bool:
        """Whether a participant is on foot."""
        return self._fixed[name].kind == ObjectKind.PEDESTRIAN

    def observe(self, ego: EgoState) -> Observation:
        """Read everybody's state as it is after the last SUMO step."""
        names, values = self._read(ego.x, ego.y)
        if names != self._names:
            self._renew(names)
        count = len(names)
        raw = np.array(values).reshape(count, 4)
        number, kind, length, width = self._static
        columns = np.empty((7, count))
        nearest = _measure(
            raw, length, width, self._before, self._interval, ego.x, ego.y, ego.yaw, ego.length, ego.width, columns
        )
        x, y, yaw, speed, acceleration, turn, distances = columns
        self._before = columns[2:4]
        around = ObjectList(number, kind, x, y, yaw, speed, acceleration, turn, length, width)
        objects = around
        if self._range < AROUND:
            objects = around.select(np.hypot(x - ego.x, y - ego.y) <= self._range)
        return Observation(objects, around, self._names, distances, nearest)

    def _read(self, x: float, y: float) -> tuple[tuple[str, ...], list[float]]:
        """Names and SUMO's values (four each) of those within reach of a point [m]."""
        vehicle, reach = libsumo.vehicle, max(self._range, AROUND) ** 2
        position, angle, speed = vehicle.getPosition, vehicle.getAngle, vehicle.getSpeed
        names: list[str] = []
        values: list[float] = []
        for name in vehicle.getIDList():
            there_x, there_y = position(name)
            if (there_x - x) ** 2 + (there_y - y) ** 2 <= reach and name != self._ego_name:
                names.append(name)
                values += (there_x, there_y, angle(name), speed(name))
        if self._with_persons:
            person = libsumo.person
            for name in person.getIDList():
                there_x, there_y = person.getPosition(name)
                if (there_x - x) ** 2 + (there_y - y) ** 2 <= reach:
                    names.append(name)
                    values += (there_x, there_y, person.getAngle(name), person.getSpeed(name))
        return tuple(names), values

    def _renew(self, names: tuple[str, ...]) -> None:
        """Somebody came or went: look up newcomers and carry the rest over; a number stays with its name."""
        before = {name: place for place, name in enumerate(self._names)}
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
        carried = np.full((2, len(names)), math.nan)
        for place, name in enumerate(names):
            if name in before:
                carried[:, place] = self._before[:, before[name]]
        self._before = carried
        self._names = names

    def _look_up(self, name: str) -> _Fixed:
        number = len(self._fixed) + 1
        if self._with_persons and name in libsumo.person.getIDList():
            # A person's outline is a body, not the point that SUMO walks; its position is its centre.
            return _Fixed(number, int(ObjectKind.PEDESTRIAN), PEDESTRIAN_LENGTH, PEDESTRIAN_WIDTH)
        kind = KINDS.get(libsumo.vehicle.getVehicleClass(name), ObjectKind.UNKNOWN)
        return _Fixed(number, int(kind), libsumo.vehicle.getLength(name), libsumo.vehicle.getWidth(name))
