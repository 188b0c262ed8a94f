"""From a list of edges to the ego's route: lane centre lines, lane changes and conflict zones."""

import heapq
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import shapely
from numpy.typing import NDArray

from roadmend.core.errors import InputError
from roadmend.core.route import RightOfWay, Route, Stage, Window, Zone
from roadmend.world.road_network import Connection, Edge, Lane, RoadNetwork
from roadmend.world.scenario import Scenario

Floats = NDArray[np.float64]

_CHANGE_TIME = 2.5  # [s] of driving at the limit that a lane change needs
_CHANGE_LENGTH_MIN = 20.0  # [m]
_END_MARGIN = (
    4.0  # [m] from the ego's front at the goal to the road's end, where SUMO takes it out: a tick at top speed
)
_SHORT = 0.5  # [m] what is shorter is no stretch of the route
_SAME_PASSAGE = 0.5  # [m] between two stretches within a crossing that are one way through it
_CROSSING_MARGIN = 1.5  # [m] to keep free before a pedestrian crossing
_YIELDING = frozenset("m=Zg")
_STOPPING = frozenset("sw")
_AROUND = frozenset("tT")  # SUMO's directions of connections that turn around


@dataclass(frozen=True)
class SignalLink:
    """Where the colour of one traffic light on the route is read from."""

    traffic_light: str
    link_index: int


@dataclass(frozen=True)
class BuiltRoute:
    """A route and what the simulation must know about it besides."""

    route: Route
    signals: tuple[SignalLink, ...]
    start_position: float  # [m] of the ego's centre on stage 0


@dataclass(frozen=True)
class _Chain:
    """Lanes one after another along the route, beginning at route edge ``first``."""

    first: int
    lanes: tuple[int, ...]  # SUMO lane number on route edge first, first + 1, ...


def build_route(network: RoadNetwork, scenario: Scenario) -> BuiltRoute:
    """The ego's route through a network.

    Raises:
        InputError: an edge does not exist, edges do not connect, a position lies outside its edge, or the goal does not
            lie ahead.
    """
    edges = _edges_of(network, scenario)
    chains = _plan_lanes(network, edges, scenario.ego.lane)
    stages: list[Stage] = []
    zones: list[Zone] = []
    signals: list[SignalLink] = []
    edge_begins: list[dict[int, float]] = []
    for index, chain in enumerate(chains):
        stage, begins, own_zones = _trace(network, edges, chain, index, signals)
        stages.append(stage)
        edge_begins.append(begins)
        zones += own_zones + _crossing_zones(network, stage, index)
    windows = tuple(
        _window(edges, chains[index], chains[index + 1], edge_begins[index], len(chains) - 1 - index)
        for index in range(len(chains) - 1)
    )
    ego = scenario.ego
    first, last = edges[0].lanes[chains[0].lanes[0]], edges[-1].lanes[chains[-1].lanes[-1]]
    if ego.position > first.length:
        raise InputError(
            "ego.position",
            f"{ego.position:g} m is past the end of {edges[0].id} ({first.length:.1f} m)",
            "choose a smaller one",
        )
    if ego.goal is not None and ego.goal > last.length:
        raise InputError(
            "ego.goal",
            f"{ego.goal:g} m is past the end of {edges[-1].id} ({last.length:.1f} m)",
            "choose a smaller one",
        )
    begin = edge_begins[-1][len(edges) - 1]
    goal = begin + (
        ego.goal if ego.goal is not None else max(last.length - 0.5 * ego.length - _END_MARGIN, 0.5 * last.length)
    )
    if len(stages) == 1 and goal <= ego.position:
        where, mend = ("ego.goal", "larger") if ego.goal is not None else ("ego.position", "smaller")
        what = f"the ego starts at {ego.position:g} m, and its goal is not ahead ({goal:.1f} m)"
        raise InputError(where, what, f"choose a {mend} one")
    route = Route(
        scenario.name,
        ego.length,
        ego.width,
        min(goal, stages[-1].length),
        scenario.time_limit,
        tuple(stages),
        windows,
        tuple(sorted(zones, key=lambda zone: (zone.stage, zone.begin))),
    )
    return BuiltRoute(route, tuple(signals), ego.position)


def _edges_of(network: RoadNetwork, scenario: Scenario) -> list[Edge]:
    if not scenario.ego.route:
        raise InputError("ego.route", "holds no edge", "name at least one edge of the network")
    for place, name in enumerate(scenario.ego.route):
        check_edge(network, name, f"ego.route[{place}]")
    edges = [network.edges[name] for name in scenario.ego.route]
    if scenario.ego.lane >= len(edges[0].car_lanes):
        raise InputError(
            "ego.lane", f"{edges[0].id} has {len(edges[0].car_lanes)} lanes for cars", "count from 0 at the right"
        )
    return edges


def check_edge(network: RoadNetwork, name: str, where: str) -> None:
    """Raise InputError unless ``name`` is a road that cars may use."""
    edge = network.edges.get(name)
    if edge is None or edge.function != "normal":
        known = ", ".join(sorted(road.id for road in network.roads)[:8])
        raise InputError(where, f"there is no edge {name!r} in the network", f"choose from {known}, ...")
    if not edge.car_lanes:
        raise InputError(where, f"edge {name!r} has no lane for cars", "choose another edge")


def easiest_lane(network: RoadNetwork, route: Sequence[str]) -> int | None:
    """The lane for cars of a route's first edge from which it takes the fewest lane changes; None if none leads along.

    Raises:
        InputError: an edge is no road for cars.
    """
    for place, name in enumerate(route):
        check_edge(network, name, f"ego.route[{place}]")
    edges = [network.edges[name] for name in route]
    changes = _changes_to_go(network, edges)
    lanes = [edges[0].lane_number(number) for number in range(len(edges[0].car_lanes))]
    fit = [(changes[0, lane], number) for number, lane in enumerate(lanes) if (0, lane) in changes]
    return min(fit)[1] if fit else None


def turns_around(network: RoadNetwork, route: Sequence[str]) -> bool:
    """Whether a route comes back on the other side of the road somewhere."""
    return any(
        connection.direction in _AROUND
        for name, following in pairwise(route)
        for lane in range(len(network.edges[name].lanes))
        for connection in network.connections.get((name, lane), [])
        if connection.to_edge == following
    )


def _links(network: RoadNetwork, edge: Edge, lane: int, following: Edge) -> list[Connection]:
    return [
        connection
        for connection in network.connections.get((edge.id, lane), [])
        if connection.to_edge == following.id and following.lanes[connection.to_lane].for_cars
    ]


def _plan_lanes(network: RoadNetwork, edges: list[Edge], first_car_lane: int) -> list[_Chain]:
    """The fewest lane changes that lead along the route, each as early as possible."""
    start = (0, edges[0].lane_number(first_car_lane))
    changes = _changes_to_go(network, edges)
    if start not in changes:
        for index in range(len(edges) - 1):
            if not any(
                _links(network, edges[index], lane, edges[index + 1]) for lane in range(len(edges[index].lanes))
            ):
                raise InputError(
                    f"ego.route[{index + 1}]",
                    f"no lane leads from {edges[index].id!r} to {edges[index + 1].id!r}",
                    "choose edges that connect",
                )
        raise InputError("ego.route", "cannot be driven with lane changes alone", "choose edges that connect")
    chains: list[_Chain] = []
    index, lane = start
    while True:
        chain = _follow(network, edges, changes, index, lane)
        chains.append(chain)
        to_go = changes[index, lane]
        if to_go == 0:
            return chains
        # The first edge on which a neighbour lane is one change closer to the goal.
        for place, here in enumerate(chain.lanes):
            edge = index + place
            closer = [other for other in (here - 1, here + 1) if changes.get((edge, other), to_go) == to_go - 1]
            if closer:
                index, lane = edge, closer[0]
                break
        else:
            raise AssertionError("the plan of lanes has a hole")


def _changes_to_go(network: RoadNetwork, edges: list[Edge]) -> dict[tuple[int, int], int]:
    """Lane changes still needed from each (route edge, lane), by a search backwards from the last edge."""
    last = len(edges) - 1
    queue = [(0, last, lane) for lane, what in enumerate(edges[last].lanes) if what.for_cars]
    changes: dict[tuple[int, int], int] = {}
    while queue:
        cost, index, lane = heapq.heappop(queue)
        if changes.get((index, lane), cost + 1) <= cost:
            continue
        changes[index, lane] = cost
        for other in (lane - 1, lane + 1):
            if 0 <= other < len(edges[index].lanes) and edges[index].lanes[other].for_cars:
                heapq.heappush(queue, (cost + 1, index, other))
        if index > 0:
            for before in range(len(edges[index - 1].lanes)):
                links = _links(network, edges[index - 1], before, edges[index])
                if any(link.to_lane == lane for link in links) and edges[index - 1].lanes[before].for_cars:
                    heapq.heappush(queue, (cost, index - 1, before))
    return changes


def _follow(
    network: RoadNetwork, edges: list[Edge], changes: dict[tuple[int, int], int], index: int, lane: int
) -> _Chain:
    lanes = [lane]
    for here in range(index, len(edges) - 1):
        links = _links(network, edges[here], lanes[-1], edges[here + 1])
        if not links:
            break
        best = min(links, key=lambda link: (changes.get((here + 1, link.to_lane), 99), link.to_lane))
        lanes.append(best.to_lane)
    return _Chain(index, tuple(lanes))


def _trace(
    network: RoadNetwork, edges: list[Edge], chain: _Chain, index: int, signals: list[SignalLink]
) -> tuple[Stage, dict[int, float], list[Zone]]:
    """Centre line of a chain, the arc length at which each route edge begins, and its junction zones."""
    points: list[Floats] = []
    limits: list[float] = []
    begins: dict[int, float] = {}
    pending: list[tuple[float, Connection]] = []
    zones: list[Zone] = []
    length = 0.0

    def append(lane: Lane) -> None:
        nonlocal length
        for point in lane.shape:
            if points:
                step = float(np.hypot(*(point - points[-1])))
                if step < 1e-3:
                    limits[-1] = lane.speed_limit
                    continue
                length += step
            points.append(point)
            limits.append(lane.speed_limit)

    for place, lane_number in enumerate(chain.lanes):
        edge = chain.first + place
        lane = edges[edge].lanes[lane_number]
        begins[edge] = length
        if pending and not pending[0][1].via:  # a network without ways through its junctions: straight across
            begins[edge] += float(np.hypot(*(lane.shape[0] - points[-1])))
        append(lane)
        for begin, connection in pending:
            zones += _junction_zones(network, connection, index, begin, begins[edge], signals)
        pending.clear()
        if place + 1 < len(chain.lanes):
            links = _links(network, edges[edge], lane_number, edges[edge + 1])
            connection = next(link for link in links if link.to_lane == chain.lanes[place + 1])
            pending.append((length, connection))
            via, passed = connection.via, set[str]()
            while via:
                if via in passed:
                    what = f"the way from {edges[edge].id!r} through its junction comes back to {via!r}"
                    raise InputError(str(network.path), what, "build the network again with netconvert")
                passed.add(via)
                append(network.lane(via))
                edge_id, _, number = via.rpartition("_")
                inner = network.connections.get((edge_id, int(number)), [])
                via = next((link.via for link in inner if link.to_edge == connection.to_edge), "")
    if len(points) < 2:
        raise InputError("ego.route", f"{edges[chain.first].id!r} has no length", "choose another edge")
    shape = np.array(points)
    stage = Stage(np.ascontiguousarray(shape[:, 0]), np.ascontiguousarray(shape[:, 1]), np.array(limits))
    return stage, begins, zones


def _junction_zones(
    network: RoadNetwork, connection: Connection, stage: int, begin: float, end: float, signals: list[SignalLink]
) -> list[Zone]:
    if end - begin < _SHORT and not connection.traffic_light:
        return []
    if connection.traffic_light:
        end = max(end, begin + _SHORT)  # a light need not stand at a junction
        link = SignalLink(connection.traffic_light, connection.link_index)
        if link not in signals:
            signals.append(link)
        zones = [Zone(stage, begin, end, RightOfWay.SIGNAL, signals.index(link))]
        phases = network.phases.get(connection.traffic_light, [])
        if any(state[connection.link_index : connection.link_index + 1] == "g" for state in phases):
            zones.append(Zone(stage, begin, end, RightOfWay.YIELD))
        return zones
    if connection.state in _STOPPING:
        return [Zone(stage, begin, end, RightOfWay.STOP)]
    rule = RightOfWay.YIELD if connection.state in _YIELDING else RightOfWay.PRIORITY
    return [Zone(stage, begin, end, rule)]


def _crossing_zones(network: RoadNetwork, stage: Stage, index: int) -> list[Zone]:
    line = shapely.LineString(np.column_stack([stage.x, stage.y]))
    zones = []
    for edge in network.edges.values():
        if edge.function != "crossing":
            continue
        for lane in edge.lanes:
            area = shapely.LineString(lane.shape).buffer(0.5 * lane.width, cap_style="flat")
            shared = line.intersection(area)
            if shared.is_empty or shared.length < _SHORT:
                continue
            passages = _passages(stage, area)
            if len(passages) < 2:
                ends = [line.project(shapely.Point(point)) for point in shapely.get_coordinates(shared)]
                passages = [(min(ends), max(ends))]
            for begin, end in passages:
                zones.append(Zone(index, max(0.0, begin - _CROSSING_MARGIN), end, RightOfWay.CROSSING))
    return zones


def _passages(stage: Stage, area: shapely.Polygon) -> list[tuple[float, float]]:
    """Arc lengths [m] between which a line is in an area, once for each time that it comes through."""
    points = np.column_stack([stage.x, stage.y])
    found: list[tuple[float, float]] = []
    segments = shapely.linestrings(np.stack([points[:-1], points[1:]], axis=1))
    for place, piece in enumerate(shapely.intersection(segments, area)):
        if piece.is_empty:
            continue
        along = stage.s[place] + np.hypot(*(shapely.get_coordinates(piece) - points[place]).T)
        begin, end = float(along.min()), float(along.max())
        if found and begin - found[-1][1] < _SAME_PASSAGE:
            begin = found.pop()[0]
        found.append((begin, end))
    return [(begin, end) for begin, end in found if end - begin >= _SHORT]


def _window(edges: list[Edge], chain: _Chain, following: _Chain, begins: dict[int, float], changes_left: int) -> Window:
    """Where the change from one chain to the next may begin: as long as the two run side by side."""
    first = following.first
    last = first
    for place, lane in enumerate(following.lanes):
        edge = first + place
        offset = edge - chain.first
        if offset >= len(chain.lanes) or abs(chain.lanes[offset] - lane) != 1:
            break
        last = edge
    begin = begins[first]
    final = edges[last].lanes[chain.lanes[last - chain.first]]
    reserve = max(_CHANGE_LENGTH_MIN, _CHANGE_TIME * final.speed_limit)
    close = begins[last] + final.length
    end = max(close - reserve * changes_left, begin + 0.25 * (close - begin))
    return Window(begin, end)
