"""How a vehicle leaves its road and strikes what stands there: the line that it drives, and where that thing stands.

The vehicle follows its lane, steers off it with a small acceleration to the side until it heads away from the lane by an
angle, and goes on so at its speed. The thing stands in its way where it is clear of the roadway for the first time.
"""

import math
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from roadmend.safe.dsl import ON_THE_ROADWAY, Side, StruckObject
from roadmend.world.drivers import Body
from roadmend.world.network import network_file
from roadmend.world.obstacle import Obstacle, ObstacleKind
from roadmend.world.road_network import RoadNetwork, read_network
from roadmend.world.scenario_networks import Network
from roadmend.world.steering import line_through

Points = list[tuple[float, float]]

LEAVING = 1.5  # [m/s2] across the way with which it is steered off its lane
_STEP = 0.5  # [m] between two places that are tried
_DRAWN = 2.0  # [m] between two points of the line
_FARTHEST = 150.0  # [m] that a vehicle goes beside its lane at most
_OVERLAP = 0.3  # [m] of the thing and the vehicle's corner, where a side is struck
_CRUSH = 0.02  # [m] by which a long thing reaches into the vehicle's way
_STOPPING = 3.0  # [m/s2] that a steered vehicle uses to stand at the end of its line
_ROUNDS = 4  # of moving the start until the end is where it shall be


@dataclass(frozen=True, slots=True)
class Thing:
    """A kind of thing that is struck.

    Attributes:
        kind: in the words of a scenario.
        length: [m]; what is longer than 2 m lies along the road.
        width: [m].
        firm: whether it stops a car.
    """

    kind: ObstacleKind
    length: float
    width: float
    firm: bool = True


THINGS = MappingProxyType(
    {
        StruckObject.TREE: Thing("tree", 0.5, 0.5),
        StruckObject.POLE: Thing("pole", 0.3, 0.3),
        StruckObject.SIGN: Thing("sign", 0.2, 0.2, firm=False),
        StruckObject.BARRIER: Thing("barrier", 16.0, 0.4),
        StruckObject.WALL: Thing("wall", 12.0, 0.4),
        StruckObject.DITCH: Thing("ditch", 25.0, 1.5, firm=False),
        StruckObject.CURB: Thing("curb", 25.0, 0.2, firm=False),
        StruckObject.PARKED_TRAILER: Thing("parked_vehicle", 13.6, 2.5),
        StruckObject.OTHER: Thing("object", 0.6, 0.6),
        StruckObject.ANIMAL: Thing("animal", 1.8, 0.6, firm=False),
        StruckObject.DEBRIS: Thing("debris", 1.0, 1.0, firm=False),
    }
)
_LONG = 2.0  # [m] from which a thing lies along the road


@dataclass(frozen=True, slots=True)
class Departure:
    """What decides how a vehicle comes off its road.

    Attributes:
        object: that it strikes.
        part: with which of its sides.
        side: to which it leaves the road.
        speed: that it has [m/s].
        angle: to its lane at which it leaves [deg]; 0 straight on, beyond the end of its road.
        clearance: of the thing from the roadway [m].
    """

    object: StruckObject
    part: Side
    side: Side
    speed: float
    angle: float
    clearance: float


@dataclass(frozen=True, slots=True)
class Struck:
    """A crash of one vehicle, laid out.

    Attributes:
        line: of the vehicle's middle [m], from the beginning of its lane on.
        obstacle: what it strikes.
        station: along the lane where the vehicle's middle is then [m].
        start: along the lane where it begins to leave [m].
        is_misplaced: whether the thing stands on the roadway, though it is of the roadside: the road was too wide.
    """

    line: Points
    obstacle: Obstacle
    station: float
    start: float
    is_misplaced: bool


def strike(network: Network, lane: Points, body: Body, way: Departure, place: float) -> Struck:
    """Lay out how a vehicle strikes something.

    Args:
        network: of the road.
        lane: centre line of the vehicle's lane, through junctions too [m].
        body: of the vehicle.
        way: how it leaves its road.
        place: along the lane where it shall happen [m].
    """
    course = _Course(read_network(network_file(network)), lane, body, way)
    start = place
    for _ in range(_ROUNDS):
        station = course.struck(start)
        start = max(start + place - station, 1.0)
    station = course.struck(start)
    obstacle = course.obstacle(start, station)
    return Struck(course.line(start, station), obstacle, station, start, course.is_misplaced(obstacle))


class _Course:
    """The way of a vehicle beside its lane, from wherever it begins to leave it."""

    def __init__(self, network: RoadNetwork, lane: Points, body: Body, way: Departure) -> None:
        import shapely  # noqa: PLC0415 - only who leaves the road needs it

        self._lane, self._body, self._way, self._thing = line_through(lane), body, way, THINGS[way.object]
        self._stays = way.object in ON_THE_ROADWAY
        lanes = [lane for edge in network.edges.values() for lane in edge.lanes if len(lane.shape) > 1]
        self._roadway = shapely.unary_union(
            [shapely.LineString(lane.shape).buffer(0.5 * lane.width, cap_style="flat") for lane in lanes]
        )

    def struck(self, start: float) -> float:
        """Where along the lane [m] the thing is met: at once on the roadway, else where it stands clear of it."""
        if self._stays:
            return start
        station = start
        while station < min(start + _FARTHEST, self._lane.length - 1.0):
            station += _STEP
            if self._is_clear(self.obstacle(start, station)):
                break
        return station

    def line(self, start: float, station: float) -> Points:
        """What the vehicle drives: along the lane, beside it, and straight on past the thing."""
        stations = [*np.arange(0.0, start, _DRAWN), *np.arange(start, station, _DRAWN), station]
        points = [self._pose(start, each)[:2] for each in stations]
        x, y, yaw = self._pose(start, station)
        beyond = self._way.speed**2 / (2.0 * _STOPPING) + (8.0 if self._thing.firm else 0.5)
        points.append((x + beyond * math.cos(yaw), y + beyond * math.sin(yaw)))
        return [(round(float(px), 3), round(float(py), 3)) for px, py in points]

    def obstacle(self, start: float, station: float) -> Obstacle:
        """The thing, where the vehicle strikes it with the part that is meant."""
        x, y, yaw = self._pose(start, station)
        thing, half = self._thing, 0.5 * self._body.width
        is_long = thing.length > _LONG
        if is_long and not self._way.angle:  # beyond the end of a road it lies across the way
            heading, forth, across = yaw + 0.5 * math.pi, 0.0, 0.0
            ahead, aside = 0.5 * (self._body.length + thing.width), 0.0
        elif is_long:  # a corner meets its face
            heading = self._lane.pose(station)[2]
            sign = 1.0 if self._way.side is Side.LEFT else -1.0
            ahead, aside = 0.5 * self._body.length, sign * half
            forth, across = 0.25 * thing.length, sign * (0.5 * thing.width - _CRUSH)
        else:
            heading, forth = yaw, 0.0
            sign = {Side.LEFT: 1.0, Side.RIGHT: -1.0}.get(self._way.part, 0.0)
            stands_across = thing.kind == "animal"
            deep, wide = (thing.width, thing.length) if stands_across else (thing.length, thing.width)
            ahead = 0.5 * (self._body.length + deep)
            aside, across = sign * (half + 0.5 * wide - min(_OVERLAP, 0.8 * wide)), 0.0
        cosine, sine, along, beside = math.cos(yaw), math.sin(yaw), math.cos(heading), math.sin(heading)
        return Obstacle(
            id=thing.kind,
            kind=thing.kind,
            x=round(float(x + ahead * cosine - aside * sine + forth * along - across * beside), 3),
            y=round(float(y + ahead * sine + aside * cosine + forth * beside + across * along), 3),
            heading=round(math.degrees(heading + (0.5 * math.pi if thing.kind == "animal" else 0.0)) % 360.0, 2),
            length=thing.length,
            width=thing.width,
            firm=thing.firm,
        )

    def is_misplaced(self, obstacle: Obstacle) -> bool:
        """Whether a thing that stands beside roads stands on this one."""
        return not self._stays and self._distance(obstacle) <= 0.0

    def _pose(self, start: float, station: float) -> tuple[float, float, float]:
        """The vehicle's middle [m] and heading [rad] beside a station of its lane."""
        x, y, heading = self._lane.pose(station)
        gone = station - start
        if gone <= 0.0 or self._stays:
            return x, y, heading
        bend = LEAVING / self._way.speed**2  # [1/m]
        slope = math.tan(math.radians(self._way.angle))
        sign = 1.0 if self._way.side is Side.LEFT else -1.0
        curved = min(gone, slope / bend)
        offset = sign * (0.5 * bend * curved**2 + slope * (gone - curved))
        turn = sign * math.atan(bend * curved)
        return x - offset * math.sin(heading), y + offset * math.cos(heading), heading + turn

    def _is_clear(self, obstacle: Obstacle) -> bool:
        """Whether a thing stands off the roadway, on the side to which the vehicle leaves."""
        margin = min(self._way.clearance, 0.05) if obstacle.kind == "curb" else self._way.clearance
        return bool(self._distance(obstacle) >= margin)

    def _distance(self, obstacle: Obstacle) -> float:
        """From the roadway to a thing [m]; 0 where it stands on it."""
        import shapely  # noqa: PLC0415

        angle = math.radians(obstacle.heading)
        box = shapely.box(-0.5 * obstacle.length, -0.5 * obstacle.width, 0.5 * obstacle.length, 0.5 * obstacle.width)
        box = shapely.affinity.rotate(box, angle, origin=(0.0, 0.0), use_radians=True)
        box = shapely.affinity.translate(box, obstacle.x, obstacle.y)
        return float(self._roadway.distance(box))
