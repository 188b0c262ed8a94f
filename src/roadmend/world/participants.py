"""Reads everybody but the ego out of SUMO, in the project's own frame and units."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum
from types import MappingProxyType
from typing import NamedTuple

import libsumo
import numpy as np
from numpy.typing import NDArray

from roadmend.core.geometry import outline_distances, wrap_angle
from roadmend.core.jit import compiled
from roadmend.core.scene import OBJECT, EgoState, ObjectKind, ObjectList, Objects
from roadmend.world.drivers import KINDS, PEDESTRIAN_LENGTH, PEDESTRIAN_WIDTH

Floats = NDArray[np.float64]

NEAR = 10.0  # [m] gap below which distances are exact
AROUND = 40.0  # [m] everybody within is watched for contact, seen or not


@compiled
def _measure(raw: Floats, objects: Objects, interval: float) -> None:
    """Bring ``objects`` from the last tick to this one; a newcomer's yaw is NaN there.

    ``raw`` (N x 4) holds SUMO's rows: front bumper x and y [m], degrees clockwise from north and speed [m/s].
    """
    for index in range(raw.shape[0]):
        one = objects[index]
        heading = wrap_angle(math.radians(90.0 - raw[index, 2]))
        is_new = math.isnan(one.yaw)
        one.acceleration = 0.0 if is_new else (raw[index, 3] - one.speed) / interval
        one.yaw_rate = 0.0 if is_new else wrap_angle(heading - one.yaw) / interval
        one.x = raw[index, 0] - 0.5 * one.length * math.cos(heading)
        one.y = raw[index, 1] - 0.5 * one.length * math.sin(heading)
        one.yaw, one.speed = heading, raw[index, 3]


class _Origin(IntEnum):
    """Where a participant is read from: SUMO's vehicles and persons are named apart, and both may be called "0"."""

    VEHICLE = 0
    PERSON = 1
    OBSTACLE = 2


_Row = tuple[_Origin, str]


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
    names: tuple[str, ...]  # SUMO's; a person with the name of a vehicle goes by another one
    distances: Floats  # [m] of their outlines to the ego's; exact below NEAR
    nearest: float  # [m] the smallest of these, infinite if there is nobody


class Pose(NamedTuple):
    """Where a vehicle's middle is [m], its yaw [rad], speed [m/s] and size [m], in the map frame."""

    x: float
    y: float
    yaw: float
    speed: float
    length: float
    width: float


_NOTHING: Mapping[str, Pose] = MappingProxyType({})


def all_vehicles(but: str) -> dict[str, Pose]:
    """Every vehicle on the map, near or far, by SUMO's name, but for one."""
    vehicle = libsumo.vehicle
    found = {}
    for name in vehicle.getIDList():
        if name == but:
            continue
        x, y = vehicle.getPosition(name)
        yaw, length = wrap_angle(math.radians(90.0 - vehicle.getAngle(name))), vehicle.getLength(name)
        x, y = x - 0.5 * length * math.cos(yaw), y - 0.5 * length * math.sin(yaw)
        found[name] = Pose(x, y, yaw, vehicle.getSpeed(name), length, vehicle.getWidth(name))
    return found


class Participants:
    """Numbers the participants of an episode and observes them tick by tick."""

    def __init__(
        self,
        ego_name: str,
        interval: float,
        sensing_range: float,
        *,
        with_persons: bool,
        elsewhere: frozenset[str] = frozenset(),
        fixed: Mapping[str, Pose] = _NOTHING,
    ) -> None:
        """Start with nobody known.

        Args:
            ego_name: SUMO's name of the ego, which is no participant.
            interval: [s] between two ticks.
            sensing_range: [m] to the middle of a vehicle or person, and to the circle around an obstacle, which may be
                as long as a street; may be infinite.
            with_persons: whether there are people on foot.
            elsewhere: edges on other levels than the ego's way; whoever is on them is not there for it.
            fixed: what stands there and is none of SUMO's, by name.
        """
        self._ego_name = ego_name
        self._interval = interval
        self._range = sensing_range  # [m], may be infinite
        self._with_persons = with_persons
        self._elsewhere = elsewhere
        self._obstacles = fixed
        self._radii = {name: 0.5 * math.hypot(pose.length, pose.width) for name, pose in fixed.items()}  # [m]
        self._fixed: dict[_Row, _Fixed] = {}
        self._named: dict[str, _Fixed] = {}  # the same by the name of an observation
        self._rows: tuple[_Row, ...] = ()
        self._names: tuple[str, ...] = ()  # in the order of the rows
        self._objects = ObjectList.empty()  # at the last tick, in the order of the rows
        self._ranges = np.empty(0)  # [m] within which each is seen

    def number_of(self, name: str) -> int:
        """The object id of a participant."""
        return self._named[name].number

    def kind_of(self, name: str) -> ObjectKind:
        """The category of a participant."""
        return ObjectKind(self._named[name].kind)

    def observe(self, ego: EgoState) -> Observation:
        """Read everybody's state as it is after the last SUMO step."""
        rows, values = self._read(ego.x, ego.y)
        if rows != self._rows:
            self._renew(rows)
        table = self._objects.table.copy()
        _measure(np.array(values).reshape(len(rows), 4), table, self._interval)
        around = objects = self._objects = ObjectList(table)
        if self._range < AROUND:
            objects = around.select(np.hypot(around.x - ego.x, around.y - ego.y) <= self._ranges)
        distances = outline_distances(ego, table, NEAR)
        return Observation(objects, around, self._names, distances, float(distances.min(initial=math.inf)))

    def _read(self, x: float, y: float) -> tuple[tuple[_Row, ...], list[float]]:
        """Sources, names and SUMO's values (four each) of those within reach of a point [m]; vehicles come first."""
        vehicle, farthest = libsumo.vehicle, max(self._range, AROUND)
        reach = farthest**2
        position, angle, speed = vehicle.getPosition, vehicle.getAngle, vehicle.getSpeed
        rows: list[_Row] = []
        values: list[float] = []
        for name in vehicle.getIDList():
            there_x, there_y = position(name)
            if (there_x - x) ** 2 + (there_y - y) ** 2 <= reach and name != self._ego_name:
                if self._elsewhere and vehicle.getRoadID(name) in self._elsewhere:
                    continue
                rows.append((_Origin.VEHICLE, name))
                values += (there_x, there_y, angle(name), speed(name))
        if self._with_persons:
            person = libsumo.person
            for name in person.getIDList():
                there_x, there_y = person.getPosition(name)
                if (there_x - x) ** 2 + (there_y - y) ** 2 <= reach:
                    if person.getVehicle(name) or person.getRoadID(name) in self._elsewhere:
                        continue  # a passenger is part of the vehicle
                    rows.append((_Origin.PERSON, name))
                    values += (there_x, there_y, person.getAngle(name), person.getSpeed(name))
        for name, pose in self._obstacles.items():
            if math.hypot(pose.x - x, pose.y - y) <= farthest + self._radii[name]:
                ahead_x, ahead_y = 0.5 * pose.length * math.cos(pose.yaw), 0.5 * pose.length * math.sin(pose.yaw)
                rows.append((_Origin.OBSTACLE, name))
                values += (pose.x + ahead_x, pose.y + ahead_y, 90.0 - math.degrees(pose.yaw), 0.0)
        return tuple(rows), values

    def _renew(self, rows: tuple[_Row, ...]) -> None:
        """Somebody came or went: look up newcomers and carry the rest over; a number stays with its row."""
        before = {row: place for place, row in enumerate(self._rows)}
        table = np.empty(len(rows), dtype=OBJECT)
        for place, row in enumerate(rows):
            if row in before:
                table[place] = self._objects.table[before[row]]
                continue
            if row not in self._fixed:
                self._fixed[row] = self._look_up(*row)
            fixed, one = self._fixed[row], table[place]
            one["id"], one["kind"], one["length"], one["width"] = fixed.number, fixed.kind, fixed.length, fixed.width
            one["yaw"] = math.nan
        self._objects, self._rows = ObjectList(table), rows
        self._ranges = np.array(
            [self._range + (self._radii[name] if source is _Origin.OBSTACLE else 0.0) for source, name in rows]
        )
        self._names = tuple(self._name_of(*row) for row in rows)
        self._named |= {name: self._fixed[row] for name, row in zip(self._names, rows, strict=True)}

    def _name_of(self, source: _Origin, name: str) -> str:
        """SUMO's name, but no vehicle's for a person: by a name SUMO is told of a vehicle."""
        is_taken = name == self._ego_name or (_Origin.VEHICLE, name) in self._fixed
        return f"person {name}" if source is _Origin.PERSON and is_taken else name

    def _look_up(self, source: _Origin, name: str) -> _Fixed:
        number = len(self._fixed) + 1
        if source is _Origin.OBSTACLE:
            pose = self._obstacles[name]
            return _Fixed(number, int(ObjectKind.UNKNOWN), pose.length, pose.width)
        if source is _Origin.PERSON:
            # A person's outline is a body, not the point that SUMO walks; its position is its centre.
            return _Fixed(number, int(ObjectKind.PEDESTRIAN), PEDESTRIAN_LENGTH, PEDESTRIAN_WIDTH)
        kind = KINDS.get(libsumo.vehicle.getVehicleClass(name), ObjectKind.UNKNOWN)
        return _Fixed(number, int(kind), libsumo.vehicle.getLength(name), libsumo.vehicle.getWidth(name))
