"""What a report's vehicles drive on: a network, and the way of each through it."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from roadmend.core.errors import InputError
from roadmend.safe.dsl import CrashScenario, DescribedVehicle
from roadmend.world.network import network_file
from roadmend.world.road_network import read_network
from roadmend.world.scenario_networks import Network
from roadmend.world.space import Parameters

MPH = 0.44704  # [m/s]
MOST_LANES = 6  # of one direction


@dataclass(frozen=True, slots=True)
class Way:
    """What a vehicle drives.

    Attributes:
        route: edges.
        lanes: those of the first edge that lead along the route, from the right.
        lane_count: how many lanes the first edge has.
        length: [m] of the first edge.
        meeting: [m] from the start of the first edge to the place of the crash.
        heading: [deg] at the start.
        turn: [deg] to the heading at the end, left is positive.
        limit: [m/s].
        stop_line: [m] from the middle of the junction, which is the map's origin; 0 where there is no junction.
        corner: radius [m] of the turn's tightest stretch; infinite without a turn.
    """

    route: tuple[str, ...]
    lanes: tuple[int, ...]
    lane_count: int
    length: float
    meeting: float
    heading: float
    turn: float
    limit: float
    stop_line: float = 0.0
    corner: float = math.inf


@dataclass(frozen=True, slots=True)
class Layout:
    """A network, each vehicle's way, and where the report could not be followed to the letter.

    ``median`` is what lies between the two directions [m]; ``stated_lanes`` are the lanes, from the right, that the
    report names, by the index of the vehicle. ``ends`` says that a vehicle that crashes alone goes straight on where its
    road ends, which its way does not.
    """

    network: Network
    ways: tuple[Way, ...]
    is_junction: bool
    adapted: tuple[str, ...]
    median: float = 0.0
    stated_lanes: Mapping[int, int] = field(default_factory=dict)
    ends: bool = False


def centre_line(network: Network, route: tuple[str, ...], lane: int) -> list[tuple[float, float]]:
    """The middle [m] of the lanes that lead along a route from a lane of its first edge, through junctions too."""
    net = read_network(network_file(network))
    edge, number = route[0], net.edges[route[0]].lane_number(lane)
    points = [*map(tuple, net.edges[edge].lanes[number].shape)]
    for following in route[1:]:
        links = [link for link in net.connections.get((edge, number), []) if link.to_edge == following]
        if not links:
            break
        via, number, edge = links[0].via, links[0].to_lane, following
        while via:
            points += map(tuple, net.lane(via).shape)
            inner, _, place = via.rpartition("_")
            via = next((link.via for link in net.connections.get((inner, int(place)), [])), "")
        points += map(tuple, net.edges[edge].lanes[number].shape)
    rounded = [(round(float(x), 3), round(float(y), 3)) for x, y in points]
    return [point for place, point in enumerate(rounded) if not place or point != rounded[place - 1]]


def chosen_lane(layout: Layout, index: int, drawn: Parameters) -> int:
    """The lane on which a vehicle starts, from 0 at the right: the stated one, else as it was drawn.

    Raises:
        InputError: no lane leads along its way.
    """
    way = layout.ways[index]
    if not way.lanes:
        raise InputError(f"vehicle {index + 1}", f"no lane leads from {way.route[0]} to {way.route[-1]}", "mend it")
    stated = layout.stated_lanes.get(index)
    if stated is not None:
        return min(way.lanes, key=lambda lane: abs(lane - stated))
    share = float(drawn[f"v{index + 1}.lane"])
    return way.lanes[min(int(share * len(way.lanes)), len(way.lanes) - 1)]


def limit_of(vehicle: DescribedVehicle) -> float:
    """The limit that is posted for a vehicle [m/s]."""
    assert vehicle.speed_limit_mph is not None
    return round(vehicle.speed_limit_mph * MPH, 2)


def lanes_each_way(crash: CrashScenario) -> tuple[int, int]:
    """Lanes of the two directions of a road; an odd one belongs to the first."""
    total = crash.road.lanes or 2
    return min(math.ceil(total / 2), MOST_LANES), min(max(total // 2, 1), MOST_LANES)
