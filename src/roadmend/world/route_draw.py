"""By chance, where the ego joins traffic that is under way, how fast, and which stretch of whose route it drives."""

import math
import random
from collections.abc import Sequence
from typing import NamedTuple

import libsumo
import numpy as np

from roadmend.core.errors import InputError
from roadmend.core.route import Stage
from roadmend.world.clearance import has_clearance
from roadmend.world.road_network import Edge, Lane, RoadNetwork
from roadmend.world.route_builder import build_route, easiest_lane, turns_around
from roadmend.world.scenario import Scenario

SHORTEST, LONGEST = 300.0, 900.0  # [m] of a drive
LEAST = 100.0  # [m] that it takes to call it one, if it can be had
_CLASSES = frozenset({"passenger", "private", "taxi", "evehicle", "hov", "vip", "custom1", "custom2"})
_ROOM = 25.0  # [m] of an edge at least, from the start on
_LATEST_GOAL = 12.0  # [m] before the end of the last edge
_TRIES = 400  # starts that are looked at in one moment
_WAYS = 40  # routes that SUMO's router is asked for where the traffic has none of use
_AT_LIGHTS = 30.0  # [s] that a traffic light takes
_SHARE_OF_TIME = 0.65  # of the time limit that a drive should take in light traffic

_GAP = 12.0  # [m] to whoever is near, beside what speeds ask for
_HEADWAY = 2.0  # [s] to those ahead and behind
_BRAKING = 3.0  # [m/s2] that nobody should need to exceed
_PACE = 0.85  # of the speed limit


class Start(NamedTuple):
    """Fields of ``scenario.Ego``."""

    route: list[str]
    lane: int
    position: float  # [m]
    speed: float  # [m/s]
    goal: float | None  # [m]


class Limits(NamedTuple):
    """Of a drive: it ends where it comes to one of the two."""

    length: float  # [m]
    time: float  # [s] that it should take in light traffic


class _Other(NamedTuple):
    """Somebody under way."""

    x: float  # [m] of the front
    y: float
    speed: float  # [m/s]
    length: float  # [m]
    lane: str
    position: float  # [m] of the front


def draw_start(network: RoadNetwork, scenario: Scenario, *, anywhere: bool = False) -> Start | None:
    """Where and how the ego begins, drawn from what this moment of the traffic offers; None: it offers nothing.

    Args:
        network: that the traffic is on.
        scenario: whose seed draws, and whose time limit and ego count.
        anywhere: take a shorter drive than ``LEAST`` too, and routes that nobody drives, for want of better ones.
    """
    numbers = random.Random(f"roadmend/route/{scenario.seed}")
    wanted = Limits(numbers.uniform(SHORTEST, LONGEST), _SHARE_OF_TIME * scenario.time_limit)
    routes = _routes(network)
    if anywhere:
        routes += _ways(network, numbers)
    others = _others()
    starts = [(route, place) for route in routes for place in range(len(route))]
    numbers.shuffle(starts)
    found: list[tuple[float, Start]] = []
    for route, place in starts[:_TRIES]:
        start, length = _start(network, route[place:], wanted, others, numbers)
        if start is not None and _is_drivable(network, scenario, start):
            if length >= SHORTEST:
                return start
            if anywhere or length >= LEAST:
                found.append((length, start))
    # Nowhere is there as much to drive: the longest stretch there is.
    return max(found)[1] if found else None


def _is_drivable(network: RoadNetwork, scenario: Scenario, start: Start) -> bool:
    """Whether the ego can follow a route, and those who come the other way can pass it."""
    ego = scenario.ego.model_copy(update=start._asdict())
    try:
        built = build_route(network, scenario.model_copy(update={"ego": ego}))
    except InputError:
        return False
    return has_clearance(network, start.route, built.route)


def _routes(network: RoadNetwork) -> list[tuple[str, ...]]:
    """What cars under way drive, each once, in an order that does not depend on SUMO's."""
    names = [name for name in libsumo.vehicle.getIDList() if libsumo.vehicle.getVehicleClass(name) in _CLASSES]
    return sorted(
        route
        for route in {tuple(libsumo.vehicle.getRoute(name)) for name in names}
        if all(name in network.edges and network.edges[name].car_lanes for name in route)
    )


def _ways(network: RoadNetwork, numbers: random.Random) -> list[tuple[str, ...]]:
    """The shortest ways between roads for cars that are drawn from all of them, the same for the same numbers."""
    roads = sorted(road.id for road in network.roads if road.car_lanes)
    pairs = [(numbers.choice(roads), numbers.choice(roads)) for _ in range(_WAYS)]
    ways = [tuple(libsumo.simulation.findRoute(*pair, "DEFAULT_VEHTYPE").edges) for pair in pairs]
    return sorted({way for way in ways if way and all(network.edges[name].car_lanes for name in way)})


def _others() -> list[_Other]:
    return [_other(name) for name in libsumo.vehicle.getIDList()]


def _other(name: str) -> _Other:
    vehicle = libsumo.vehicle
    x, y = vehicle.getPosition(name)
    lane, position = vehicle.getLaneID(name), vehicle.getLanePosition(name)
    return _Other(x, y, vehicle.getSpeed(name), vehicle.getLength(name), lane, position)


def _start(
    network: RoadNetwork, route: Sequence[str], wanted: Limits, others: Sequence[_Other], numbers: random.Random
) -> tuple[Start | None, float]:
    """A start on the first edge of a route, and the length [m] of what follows; ``numbers`` move on all the same."""
    share = numbers.random()
    edge = network.edges[route[0]]
    if max(lane.length for lane in edge.car_lanes) < 2.0 * _ROOM:
        return None, 0.0
    first = min(lane.length for lane in edge.car_lanes)
    position = round(_ROOM + share * max(0.0, min(first - 2.0 * _ROOM, 0.6 * first)), 2)
    edges, goal, length = _stretch(network, route, position, wanted)
    if turns_around(network, edges):
        return None, 0.0
    number = easiest_lane(network, edges)
    if number is None:
        return None, 0.0
    lane = edge.car_lanes[number]
    speed = _speed(edge, lane, position, others)
    if speed is None:
        return None, 0.0
    return Start(list(edges), number, position, round(speed, 2), goal), length


def _stretch(
    network: RoadNetwork, route: Sequence[str], position: float, limits: Limits
) -> tuple[Sequence[str], float | None, float]:
    """As much of a route as is wanted: its edges, the goal on the last one [m], and how long it is [m]."""
    driven, time = -position, 0.0
    for place, name in enumerate(route):
        lanes = network.edges[name].car_lanes
        length = min(lane.length for lane in lanes)
        latest = length - _LATEST_GOAL
        time += length / (_PACE * lanes[0].speed_limit) if lanes[0].speed_limit > 0.0 else math.inf
        if (driven + length >= limits.length or time >= limits.time) and latest > _ROOM:
            goal = round(min(latest, max(limits.length - driven, _ROOM)), 2)
            return route[: place + 1], goal, driven + goal
        driven += length
        time += _AT_LIGHTS if _has_lights(network, name) else 0.0
    return route, None, driven


def _has_lights(network: RoadNetwork, edge: str) -> bool:
    """Whether there is a traffic light at the end of an edge."""
    lanes = range(len(network.edges[edge].lanes))
    return any(link.traffic_light for lane in lanes for link in network.connections.get((edge, lane), []))


def _speed(edge: Edge, lane: Lane, position: float, others: Sequence[_Other]) -> float | None:
    """A speed [m/s] at which the ego may appear on a lane without anybody's having to brake hard; None: there is none."""
    line = Stage(lane.shape[:, 0], lane.shape[:, 1], np.full(len(lane.shape), lane.speed_limit))
    x, y, yaw = line.pose(position)
    pace = _PACE * lane.speed_limit
    # It shall be able to stop at the end of the lane, wherever the route leads from there.
    speed = min(pace, math.sqrt(2.0 * _BRAKING * max(0.0, lane.length - position - _GAP)))
    here = {each.id for each in edge.lanes}
    for other in others:
        if other.lane == lane.id:
            ahead, behind = other.position - other.length - position, position - other.position
            if ahead > 0.0:
                if ahead < _GAP:
                    return None
                speed = min(speed, math.sqrt(other.speed**2 + 2.0 * _BRAKING * (ahead - _GAP)))
                speed = min(speed, other.speed + (ahead - _GAP) / _HEADWAY)
            elif behind < _GAP + other.length:
                return None
    for other in others:
        distance = math.hypot(other.x - x, other.y - y)
        if other.lane == lane.id:
            is_behind = other.position < position
        elif other.lane in here:
            is_behind = False
            if distance < 2.0 * _GAP:
                return None
        else:
            # Perhaps on the way here, perhaps not.
            is_behind = math.cos(yaw) * (other.x - x) + math.sin(yaw) * (other.y - y) < 0.0
        need = _GAP + max(0.0, other.speed**2 - speed**2) / (2.0 * _BRAKING) + 0.5 * _HEADWAY * other.speed
        if is_behind and distance < need:
            return None
    return speed
