"""What a scenario's map says of a place on it, and where a vehicle's way leads."""

import math
from collections.abc import Sequence

import numpy as np

from roadmend.world.network import network_file
from roadmend.world.road_network import read_network
from roadmend.world.scenario import Scenario
from roadmend.world.scenario_actors import Follow, Vehicle
from roadmend.world.scenario_networks import IntersectionNetwork, Network, OnRampNetwork, OpenRoadNetwork

ACCESS_LENGTH = 60.0  # [m] up to which an arm is an access to a property and no road
_AT_JUNCTION = 50.0  # [m] from a junction's middle within which a place belongs to it
_EDGE = 0.1  # [m] at a lane's edge that counts as beside it
_AT_BEND = 40.0  # [m] beyond a bend within which a place belongs to it


def roads_at(network: Network, x: float, y: float) -> frozenset[str]:
    """The types of road, in the scenario language's words, that describe a place [m] of a map made for a report."""
    match network:
        case OnRampNetwork():
            return frozenset({"Merging"})
        case OpenRoadNetwork():
            half = 0.5 * math.radians(abs(network.bend)) * network.radius
            bends = bool(network.bend) and math.hypot(x, y) <= half + _AT_BEND
            return frozenset({"Curve" if bends else "Straight"})
        case IntersectionNetwork():
            if math.hypot(x, y) > _AT_JUNCTION:
                return frozenset({"Straight"})
            arms = sum(arm.length > ACCESS_LENGTH for arm in network.arms)
            names = {"Intersection" if len(network.arms) > 3 else "T-intersection"}
            if arms < len(network.arms):  # with a driveway: reports call the place either
                names.add({4: "Intersection", 3: "T-intersection"}.get(arms, "Straight"))
            return frozenset(names)
        case _:
            return frozenset()


def stem_at(network: Network) -> float | None:
    """Side of the stem of a T-intersection, seen from its middle [rad]; None where there is no such stem."""
    if not isinstance(network, IntersectionNetwork) or len(network.arms) != 3:
        return None
    bearings = [arm.bearing for arm in network.arms]
    for bearing in bearings:
        if all(abs(math.remainder(other - bearing + 180.0, 360.0)) > 45.0 for other in bearings):
            return math.radians(bearing)
    return None


def is_on_roadway(network: Network, x: float, y: float) -> bool:
    """Whether a place [m] is on a lane, and not only at its edge."""
    lanes = [lane for edge in read_network(network_file(network)).edges.values() for lane in edge.lanes]
    return any(abs(_beside(lane.shape, x, y)) < 0.5 * lane.width - _EDGE for lane in lanes if len(lane.shape) > 1)


def beside_its_way(scenario: Scenario, actor: str, x: float, y: float) -> float:
    """Metres from the lane that a vehicle starts on, and those that follow it, to a place [m]; left is positive."""
    vehicle = next((each for each in scenario.actors if isinstance(each, Vehicle) and each.id == actor), None)
    if vehicle is None:
        return math.nan
    edges = read_network(network_file(scenario.network)).edges
    lanes = [edges[name].car_lanes for name in vehicle.route]
    return min((_beside(each[min(vehicle.lane, len(each) - 1)].shape, x, y) for each in lanes), key=abs)


def heading_at_end(scenario: Scenario, actor: str | None, *, of_route: bool = False) -> list[float]:
    """Headings [rad] that describe where a vehicle goes: at the end of its way, and in a bend at the middle of it too.

    Its way is its route or, where it follows a line of its own, that line: a U-turn leads back.

    Args:
        scenario: what was run.
        actor: name of a vehicle; None for the ego.
        of_route: whether its line is not asked for, since that leads where it did not mean to go.
    """
    vehicles = {each.id: each for each in scenario.actors if isinstance(each, Vehicle)}
    if actor is not None and actor not in vehicles:
        return [math.nan]
    manoeuvres = [] if actor is None or of_route else vehicles[actor].manoeuvres
    follow = next((each for each in reversed(manoeuvres) if isinstance(each, Follow)), None)
    if follow is not None:
        return [_heading(*follow.points[-2:]) + (math.pi if follow.backwards else 0.0)]
    route = scenario.ego.route if actor is None else vehicles[actor].route
    shape = read_network(network_file(scenario.network)).edges[route[-1]].car_lanes[0].shape
    headings = [_heading(shape[-2], shape[-1])]
    if len(route) == 1:
        headings = [_heading(*shape[(len(shape) - 1) // 2 :][:2]), *headings]
    return headings


def _beside(shape: np.ndarray, x: float, y: float) -> float:
    """Distance [m] of a place from the nearest point of a line, left of it positive."""
    begin, steps = shape[:-1], np.diff(shape, axis=0)
    offset = np.array((x, y)) - begin
    share = np.clip((offset * steps).sum(axis=1) / np.maximum((steps**2).sum(axis=1), 1e-9), 0.0, 1.0)
    gaps = np.hypot(*(offset - share[:, None] * steps).T)
    nearest = int(np.argmin(gaps))
    left = steps[nearest, 0] * offset[nearest, 1] - steps[nearest, 1] * offset[nearest, 0]
    return math.copysign(float(gaps[nearest]), float(left))


def _heading(begin: Sequence[float] | np.ndarray, end: Sequence[float] | np.ndarray) -> float:
    return math.atan2(float(end[1] - begin[1]), float(end[0] - begin[0]))
