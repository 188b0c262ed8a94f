"""From the road of a crash report to a road network, and the way that each vehicle takes through it."""

from dataclasses import replace

from roadmend.safe.compass import BEARING, HEADING, wrap_degrees
from roadmend.safe.dsl import Action, CrashScenario, DescribedVehicle, Position, RoadType, Side
from roadmend.safe.junction_layout import lay_out_junction
from roadmend.safe.stated import bend_side, lanes_of, main_heading, median_of
from roadmend.safe.ways import MOST_LANES, Layout, Way, lanes_each_way, limit_of
from roadmend.world.ego import GRAVITY
from roadmend.world.network import network_file
from roadmend.world.road_network import read_network
from roadmend.world.scenario_networks import OnRampNetwork, OpenRoadNetwork
from roadmend.world.space import Parameters

_ROAD_LENGTH = 600.0  # [m]
_AFTER_THE_NOSE = 100.0  # [m] on the acceleration lane to the place where merging traffic meets
_HASTE = 1.25  # times the limit at which a bend can still be driven
_IN_A_BEND = 0.4 * GRAVITY  # [m/s2] across the way there


def lay_out(crash: CrashScenario, drawn: Parameters) -> Layout:
    """The road network of a report without null fields.

    Args:
        crash: as :func:`roadmend.safe.open_questions.answer` gives it.
        drawn: the point that it was filled in from.
    """
    layout = replace(_lay_out(crash, drawn), stated_lanes=lanes_of(crash))
    if crash.road.lanes is not None and crash.road.lanes > 2 * MOST_LANES:
        text = f"{crash.road.lanes} lanes in all: built with {MOST_LANES} in each direction"
        return replace(layout, adapted=(*layout.adapted, text))
    return layout


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
    return lay_out_junction(crash, drawn, headings)


def _heading(vehicle: DescribedVehicle) -> int:
    assert vehicle.initial_position is not None
    return HEADING[vehicle.initial_position]


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
    forward, backward = lanes_each_way(crash)
    if crash.road.lanes == 1:
        backward = int(any(oncoming))
        if backward:
            adapted.append("one lane in all, but vehicles in both directions: one lane each")
    limits = [
        [limit_of(vehicle) for vehicle, comes in zip(crash.vehicles, oncoming, strict=True) if comes is against]
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
        ways.append(Way((edge,), tuple(range(count)), count, length, 0.5 * length, heading, turn, limit_of(vehicle)))
    return Layout(network, tuple(ways), is_junction=False, adapted=tuple(adapted), median=network.median)


def _radius_for(limit: float) -> float:
    """Radius [m] of a bend that a road with a limit [m/s] has: one that is driven well beyond the limit too."""
    return round((_HASTE * limit) ** 2 / _IN_A_BEND, 0)


def _merging(crash: CrashScenario, drawn: Parameters) -> Layout:
    lanes, leads = lanes_each_way(crash)[0], main_heading(crash)
    bearing = float(BEARING[leads]) if leads is not None else 0.0
    limits = {
        position: [limit_of(vehicle) for vehicle in crash.vehicles if vehicle.initial_position is position]
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
            Way(route, tuple(range(count)), count, before, before + _AFTER_THE_NOSE, bearing, 0.0, limit_of(vehicle))
        )
    turned = [
        f"vehicle {n}: {v.action} read as going with the merge"
        for n, v in enumerate(crash.vehicles, 1)
        if v.action is not Action.MOVE_FORWARD
    ]
    return Layout(network, tuple(ways), is_junction=False, adapted=tuple(turned))
