"""From the road of a crash report to a road network, and the way that each vehicle takes through it."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from roadmend.safe.compass import BEARING, HEADING, SIDE_AT, TURN, wrap_degrees
from roadmend.safe.dsl import Action, Compass, CrashScenario, DescribedVehicle, Position, RoadType, Side
from roadmend.safe.stated import bend_side, control_of, lanes_of, main_heading, median_of
from roadmend.world.network import network_file
from roadmend.world.road_network import Lane, RoadNetwork, read_network
from roadmend.world.scenario import Arm, IntersectionNetwork, Network, OnRampNetwork, OpenRoadNetwork
from roadmend.world.space import Parameters

MPH = 0.44704  # [m/s]
_ROAD_LENGTH = 600.0  # [m]
_ARM_LENGTH = 240.0  # [m]
_AFTER_THE_NOSE = 100.0  # [m] on the acceleration lane to the place where merging traffic meets
_HASTE = 1.25  # times the limit at which a bend can still be driven
_IN_A_BEND = 0.4 * 9.81  # [m/s2] across the way there
_TIGHTER = 0.75  # share of the radius that would fit into a corner which a turn's tightest stretch has
_DRIVEWAY = 50.0  # [m] of a way to a property
_ACCESS = 6.7  # [m/s] limit there
_MOST_LANES = 6  # of one direction


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
    report names, by the index of the vehicle.
    """

    network: Network
    ways: tuple[Way, ...]
    is_junction: bool
    adapted: tuple[str, ...]
    median: float = 0.0
    stated_lanes: Mapping[int, int] = field(default_factory=dict)


def lay_out(crash: CrashScenario, drawn: Parameters) -> Layout:
    """The road network of a report without null fields.

    Args:
        crash: as :func:`roadmend.safe.open_questions.answer` gives it.
        drawn: the point that it was filled in from.
    """
    layout = replace(_lay_out(crash, drawn), stated_lanes=lanes_of(crash))
    if crash.road.lanes is not None and crash.road.lanes > 2 * _MOST_LANES:
        text = f"{crash.road.lanes} lanes in all: built with {_MOST_LANES} in each direction"
        return replace(layout, adapted=(*layout.adapted, text))
    return layout


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


def _lay_out(crash: CrashScenario, drawn: Parameters) -> Layout:
    if crash.road.road_type is RoadType.MERGING:
        return _merging(crash, drawn)
    headings = [_heading(vehicle) for vehicle in crash.vehicles]
    turns = any(vehicle.action is not Action.MOVE_FORWARD for vehicle in crash.vehicles)
    crossing = any((heading - headings[0]) % 180 for heading in headings)
    if crash.road.road_type is RoadType.CURVE and not turns:
        return _road(crash, drawn, headings)
    if crash.road.road_type is RoadType.STRAIGHT and not turns and not crossing:
        return _road(crash, drawn, headings)
    return _junction(crash, drawn, headings)


def _heading(vehicle: DescribedVehicle) -> int:
    assert vehicle.initial_position is not None
    return HEADING[vehicle.initial_position]


def _lanes(crash: CrashScenario) -> tuple[int, int]:
    """Lanes of the two directions of a road; an odd one belongs to the first."""
    total = crash.road.lanes or 2
    return min(math.ceil(total / 2), _MOST_LANES), min(max(total // 2, 1), _MOST_LANES)


def _road(crash: CrashScenario, drawn: Parameters, headings: list[int]) -> Layout:
    adapted = []
    first = headings[0]
    bend = 0.0
    if crash.road.road_type is RoadType.CURVE:
        told = bend_side(crash)
        goes_left = told is Side.LEFT if told is not None else drawn["bend"] == "left"
        bend = float(drawn["bend_angle"]) * (1.0 if goes_left else -1.0)
        across = [heading for heading in headings if (heading - first) % 180]
        if across:
            # Who comes round the bend towards the first vehicle is named by the direction before the bend.
            bend = wrap_degrees(across[0] + 180 - first)
    oncoming = [(heading - first) % 360 >= 90 for heading in headings]
    forward, backward = _lanes(crash)
    if crash.road.lanes == 1:
        backward = int(any(oncoming))
        if backward:
            adapted.append("one lane in all, but vehicles in both directions: one lane each")
    limits = [
        [_limit(vehicle) for vehicle, comes in zip(crash.vehicles, oncoming, strict=True) if comes is against]
        for against in (False, True)
    ]
    network = OpenRoadNetwork(
        lanes=forward,
        backward_lanes=backward,
        bearing=float(first),
        bend=bend,
        radius=max(float(drawn["bend_radius"]), _radius_for(max(limits[0] + limits[1]))) if bend else 100.0,
        length=_ROAD_LENGTH,
        speed_limit=max(limits[0]),
        backward_speed_limit=max(limits[1] or limits[0]),
        median=median_of(crash) if backward else 0.0,
    )
    net = read_network(network_file(network))
    ways = []
    for vehicle, comes in zip(crash.vehicles, oncoming, strict=True):
        edge, count = ("backward", backward) if comes else ("forward", forward)
        heading = wrap_degrees(first + bend + 180.0) if comes else float(first)
        length = net.edges[edge].lanes[0].length
        turn = -bend if comes else bend
        ways.append(Way((edge,), tuple(range(count)), count, length, 0.5 * length, heading, turn, _limit(vehicle)))
    return Layout(network, tuple(ways), is_junction=False, adapted=tuple(adapted), median=network.median)


def _radius_for(limit: float) -> float:
    """Radius [m] of a bend that a road with a limit [m/s] has: one that is driven well beyond the limit too."""
    return round((_HASTE * limit) ** 2 / _IN_A_BEND, 0)


def _limit(vehicle: DescribedVehicle) -> float:
    assert vehicle.speed_limit_mph is not None
    return round(vehicle.speed_limit_mph * MPH, 2)


def _merging(crash: CrashScenario, drawn: Parameters) -> Layout:
    lanes, leads = _lanes(crash)[0], main_heading(crash)
    bearing = float(BEARING[leads]) if leads is not None else 0.0
    limits = {
        position: [_limit(vehicle) for vehicle in crash.vehicles if vehicle.initial_position is position]
        for position in (Position.MAIN_ROAD, Position.ON_RAMP)
    }
    fastest = max(limits[Position.MAIN_ROAD] or limits[Position.ON_RAMP])
    network = OnRampNetwork(
        lanes=lanes,
        speed_limit=fastest,
        ramp_speed_limit=min(fastest, max(limits[Position.ON_RAMP] or [20.0])),
        approach_length=400.0,
        ramp_length=float(drawn["ramp_length"]),
        lane_length=float(drawn["lane_length"]),
        bearing=bearing,
    )
    net = read_network(network_file(network))
    ways = []
    for vehicle in crash.vehicles:
        if vehicle.initial_position is Position.ON_RAMP:
            route, count, before = ("ramp", "merge", "mainline"), 1, net.edges["ramp"].lanes[0].length
        else:
            route, count, before = ("approach", "merge", "mainline"), lanes, net.edges["approach"].lanes[0].length
        ways.append(
            Way(route, tuple(range(count)), count, before, before + _AFTER_THE_NOSE, bearing, 0.0, _limit(vehicle))
        )
    turned = [
        f"vehicle {n}: {v.action} read as going with the merge"
        for n, v in enumerate(crash.vehicles, 1)
        if v.action is not Action.MOVE_FORWARD
    ]
    return Layout(network, tuple(ways), is_junction=False, adapted=tuple(turned))


def _junction(crash: CrashScenario, drawn: Parameters, headings: list[int]) -> Layout:
    sources = [SIDE_AT[(heading + 180) % 360] for heading in headings]
    exits = [
        SIDE_AT[(heading + TURN[vehicle.action]) % 360]
        for heading, vehicle in zip(headings, crash.vehicles, strict=True)
        if isinstance(vehicle.action, Action)
    ]
    sides, accesses, adapted = _sides(crash, sources, exits)
    main = _main_road(crash, sources, drawn)
    forward, backward = _lanes(crash)
    arms = []
    for side in sides:
        if side in accesses:
            arms.append(
                Arm(name=side.value.lower(), bearing=float(BEARING[side]), speed_limit=_ACCESS, length=_DRIVEWAY)
            )
            continue
        is_larger = side in main or drawn["crossing_road"] == "as_large"
        into, out = (forward, backward) if is_larger else (1, 1)
        own = [_limit(v) for v, source in zip(crash.vehicles, sources, strict=True) if source is side]
        own = own or [_limit(v) for v, source in zip(crash.vehicles, sources, strict=True) if _same_axis(source, side)]
        arms.append(
            Arm(
                name=side.value.lower(),
                bearing=float(BEARING[side]),
                lanes=into,
                lanes_out=out if out != into else None,
                speed_limit=max(own or [min(_limit(v) for v in crash.vehicles)]),
                length=_ARM_LENGTH,
                major=bool(accesses) or _same_axis(side, sources[0]) == (drawn["control"] == "first_major"),
                median=median_of(crash) if is_larger else 0.0,
            )
        )
    control = control_of(crash) or str(drawn["control"])
    if accesses or control.endswith("_major"):
        control = "priority"
    network = IntersectionNetwork.model_validate({"arms": arms, "control": control})
    net = read_network(network_file(network))
    ways = tuple(
        _through(net, source, to, heading, vehicle)
        for source, to, heading, vehicle in zip(sources, exits, headings, crash.vehicles, strict=True)
    )
    return Layout(network, ways, is_junction=True, adapted=tuple(adapted))


def _same_axis(one: Compass, other: Compass) -> bool:
    return (BEARING[one] - BEARING[other]) % 180 == 0


def _sides(
    crash: CrashScenario, sources: list[Compass], exits: list[Compass]
) -> tuple[list[Compass], set[Compass], list[str]]:
    """Where roads meet the junction, counter-clockwise from east; which of them are driveways; what was added."""
    needed = {*sources, *exits}
    accesses: set[Compass] = set()
    match crash.road.road_type:
        case RoadType.INTERSECTION:
            return [*SIDE_AT.values()], set(), []
        case RoadType.T_INTERSECTION:
            stem = crash.road.stem
            assert stem is not None
            own = {stem} | {side for side in Compass if not _same_axis(side, stem)}
            extra = needed - own
            text = "vehicles use the {} road, which a T-intersection with its stem in the {} does not have"
            adapted = [text.format(side, stem) for side in sorted(extra)]
        case _:
            through = _through_road(crash, sources)
            own = {side for side in Compass if _same_axis(side, through)}
            accesses = extra = needed - own
            adapted = [
                f"a {crash.road.road_type} road got a driveway to the {side}, which vehicles use"
                for side in sorted(extra)
            ]
            if not extra:
                extra = {side for side in Compass if not _same_axis(side, sources[0])}
    return [side for side in SIDE_AT.values() if side in own | extra], accesses, adapted


def _through_road(crash: CrashScenario, sources: list[Compass]) -> Compass:
    """A side of the road that goes through where others only have driveways: who does not turn is on it."""
    for vehicle, source in zip(crash.vehicles, sources, strict=True):
        if vehicle.action is Action.MOVE_FORWARD:
            return source
    return sources[0]


def _main_road(crash: CrashScenario, sources: list[Compass], drawn: Parameters) -> set[Compass]:
    """The larger road, which has the report's number of lanes."""
    if crash.road.road_type is RoadType.T_INTERSECTION and crash.road.stem is not None:
        stem = crash.road.stem
        return {side for side in Compass if not _same_axis(side, stem)}
    first = drawn["control"] != "other_major"
    return {side for side in Compass if _same_axis(side, sources[0]) == first}


def _through(net: RoadNetwork, source: Compass, to: Compass, heading: int, vehicle: DescribedVehicle) -> Way:
    assert isinstance(vehicle.action, Action)
    begin, end = f"{source.value.lower()}_in", f"{to.value.lower()}_out"
    edge = net.edges[begin]
    lanes, inside, corner = [], 0.0, math.inf
    for number in range(len(edge.car_lanes)):
        for link in net.connections.get((begin, edge.lane_number(number)), []):
            if link.to_edge == end:
                lanes.append(number)
                inside = net.lane(link.via).length if link.via else 0.0
                if TURN[vehicle.action]:
                    after = net.edges[end].lanes[link.to_lane]
                    corner = min(corner, _corner_radius(edge.car_lanes[number], after, heading))
                break
    length = edge.car_lanes[0].length
    whole = float(np.hypot(*edge.car_lanes[0].shape[0]))  # the middle is the origin; lanes lie beside it
    return Way(
        (begin, end),
        tuple(lanes),
        len(edge.car_lanes),
        length,
        length + 0.5 * inside,
        float(heading),
        float(TURN[vehicle.action]),
        _limit(vehicle),
        whole - length,
        corner,
    )


def _corner_radius(before: Lane, after: Lane, heading: int) -> float:
    """Radius [m] of the tightest stretch of a turn from the end of one lane to the start of another."""
    dx, dy = after.shape[0] - before.shape[-1]
    angle = math.radians(heading)
    ahead = abs(math.cos(angle) * dx + math.sin(angle) * dy)
    aside = abs(math.cos(angle) * dy - math.sin(angle) * dx)
    return max(_TIGHTER * min(ahead, aside), 5.0)
