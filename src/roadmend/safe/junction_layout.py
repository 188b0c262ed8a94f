"""A junction of a report as a road network: its arms, their lanes and control, driveways, and the ways through it."""

import math

import numpy as np

from roadmend.safe.compass import BEARING, SIDE_AT, TURN
from roadmend.safe.dsl import Action, Compass, CrashScenario, DescribedVehicle, Manoeuvre, RoadType
from roadmend.safe.staging import is_alone
from roadmend.safe.stated import control_of, median_of
from roadmend.safe.ways import Layout, Way, lanes_each_way, limit_of
from roadmend.world.network import network_file
from roadmend.world.road_network import Lane, RoadNetwork, read_network
from roadmend.world.scenario_networks import Arm, IntersectionNetwork
from roadmend.world.space import Parameters

_ARM_LENGTH = 240.0  # [m]
_DRIVEWAY = 50.0  # [m] of a way to a property
_ACCESS = 6.7  # [m/s] limit there
_TIGHTER = 0.75  # share of the radius that would fit into a corner which a turn's tightest stretch has


def lay_out_junction(crash: CrashScenario, drawn: Parameters, headings: list[int]) -> Layout:
    """The network of a crash at a junction, or at a driveway of a road, and everybody's way.

    Args:
        crash: a report without null fields.
        drawn: the point that it was filled in from.
        headings: of the vehicles [deg].
    """
    sources = [SIDE_AT[(heading + 180) % 360] for heading in headings]
    exits = [
        SIDE_AT[(heading + TURN[vehicle.action]) % 360]
        for heading, vehicle in zip(headings, crash.vehicles, strict=True)
        if isinstance(vehicle.action, Action)
    ]
    ends = is_alone(crash) and crash.road.stem is sources[0] and _same_axis(exits[0], sources[0])
    if ends:  # straight on where the road ends is off the road; to the map it is a way to the right
        exits = [SIDE_AT[(headings[0] - 90) % 360]]
    sides, accesses, adapted = _sides(crash, sources, exits)
    main = _main_road(crash, sources, drawn)
    forward, backward = lanes_each_way(crash)
    arms = []
    for side in sides:
        if side in accesses:
            arms.append(
                Arm(name=side.value.lower(), bearing=float(BEARING[side]), speed_limit=_ACCESS, length=_DRIVEWAY)
            )
            continue
        is_larger = side in main or drawn["crossing_road"] == "as_large"
        into, out = (forward, backward) if is_larger else (1, 1)
        own = [limit_of(v) for v, source in zip(crash.vehicles, sources, strict=True) if source is side]
        own = own or [
            limit_of(v) for v, source in zip(crash.vehicles, sources, strict=True) if _same_axis(source, side)
        ]
        arms.append(
            Arm(
                name=side.value.lower(),
                bearing=float(BEARING[side]),
                lanes=into,
                lanes_out=out if out != into else None,
                speed_limit=max(own or [min(limit_of(v) for v in crash.vehicles)]),
                length=_ARM_LENGTH,
                major=_is_major(crash, side, sources[0], drawn, with_accesses=bool(accesses)),
                median=median_of(crash) if is_larger else 0.0,
            )
        )
    control = control_of(crash) or str(drawn["control"])
    if accesses or control.endswith("_major"):
        control = "priority"
    phase = float(drawn["phase"]) if control == "traffic_light" else 0.0
    network = IntersectionNetwork.model_validate({"arms": arms, "control": control, "phase": phase})
    net = read_network(network_file(network))
    ways = tuple(
        _through(net, source, to, heading, vehicle)
        for source, to, heading, vehicle in zip(sources, exits, headings, crash.vehicles, strict=True)
    )
    return Layout(network, ways, is_junction=True, adapted=tuple(adapted), ends=ends)


def _is_major(crash: CrashScenario, side: Compass, first: Compass, drawn: Parameters, *, with_accesses: bool) -> bool:
    """Whether an arm has the right of way: all but driveways; the road that goes through; else as drawn."""
    if with_accesses:
        return True
    if crash.road.stem is not None and control_of(crash) is not None:
        return side is not crash.road.stem
    return _same_axis(side, first) == (drawn["control"] == "first_major")


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
        if vehicle.action is Action.MOVE_FORWARD and vehicle.manoeuvre is not Manoeuvre.LEAVE_DRIVEWAY:
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
        limit_of(vehicle),
        whole - length,
        corner,
    )


def _corner_radius(before: Lane, after: Lane, heading: int) -> float:
    """Radius [m] of the tightest stretch of a turn from the end of one lane to the start of another."""
    dx, dy = after.shape[0] - before.shape[-1]
    angle = math.radians(heading)
    ahead = abs(math.cos(angle) * dx + math.sin(angle) * dy)
    aside = abs(math.cos(angle) * dy - math.sin(angle) * dx)
    return max(_TIGHTER * float(min(ahead, aside)), 5.0)
