"""Where on its route the ego is, in the words of traffic: before, in or behind a junction, on a ramp, on a crossing."""

import itertools
import math
from collections.abc import Sequence

from roadmend.core.geometry import wrap_angle
from roadmend.core.outcome import Event, EventKind
from roadmend.core.route import RightOfWay, Route, Zone
from roadmend.core.scene import EgoState
from roadmend.measures.route_progress import RoutePlace
from roadmend.sera.descriptor import Descriptor
from roadmend.sera.incident import EgoAction, IncidentPlace, PlaceKind
from roadmend.world.ego import STANDING, RouteFollower

NEAR = 30.0  # [m] around a junction that counts as before or behind it
_TURN = math.radians(30.0)  # of the way through a junction, from which on it is a turn
_HIGHWAYS = frozenset({"highway_exit", "on_ramp"})


def place_of(route: Route, place: RoutePlace, descriptor: Descriptor | None, *, on_foot: bool = False) -> IncidentPlace:
    """The place in words.

    Args:
        route: of the ego.
        place: of the ego's centre on it.
        descriptor: of the scenario; without it highways are roads like others.
        on_foot: whether the other is a pedestrian: where crossing and junction overlap, it is about the crossing then.
    """
    if descriptor is not None and descriptor.road.kind in _HIGHWAYS:
        return _on_highway(route, place, descriptor)
    half = 0.5 * route.ego_length
    front, rear = place.position + half, place.position - half
    zones = [zone for zone in route.zones if zone.stage == place.stage]
    inside = [zone for zone in zones if zone.begin <= front and rear <= zone.end]
    crossing = next((zone for zone in inside if zone.rule == RightOfWay.CROSSING), None)
    junctions = [zone for zone in zones if zone.rule != RightOfWay.CROSSING]
    within = next((zone for zone in inside if zone in junctions), None)
    if crossing is not None and (within is None or on_foot):
        return _at("at_crossing", place, crossing, front)
    if within is not None:
        return _at("in_junction", place, within, front)
    ahead = next((zone for zone in junctions if 0.0 < zone.begin - front <= NEAR), None)
    if ahead is not None:
        return _at("before_junction", place, ahead, front)
    behind = next((zone for zone in reversed(junctions) if 0.0 < rear - zone.end <= NEAR), None)
    if behind is not None:
        return _at("after_junction", place, behind, front)
    return IncidentPlace("lane", place.stage)


def junction_zone(route: Route, place: RoutePlace) -> Zone | None:
    """The junction whose conflict zone the ego's outline is in."""
    half = 0.5 * route.ego_length
    return next(
        (
            zone
            for zone in route.zones
            if zone.stage == place.stage
            and zone.rule != RightOfWay.CROSSING
            and zone.begin <= place.position + half
            and place.position - half <= zone.end
        ),
        None,
    )


def action_of(route: Route, place: RoutePlace, ego: EgoState, where: IncidentPlace, *, changing: bool) -> EgoAction:
    """What the ego is doing."""
    if ego.speed < STANDING:
        return "standing"
    if changing:
        return "changing_lane"
    zone = junction_zone(route, place)
    if where.kind not in {"in_junction", "at_crossing"} or zone is None:
        return "driving_on"
    stage = route.stages[place.stage]
    turn = wrap_angle(stage.pose(zone.end)[2] - stage.pose(zone.begin)[2])
    if abs(turn) < _TURN:
        return "crossing_straight"
    return "turning_left" if turn > 0.0 else "turning_right"


def is_changing(events: Sequence[Event], egos: Sequence[tuple[float, EgoState]]) -> bool:
    """Whether a lane change is under way at the last of the ego's poses, each with its time [s]."""
    begun = max((event.time for event in events if event.kind == EventKind.CHANGE_LANE), default=math.inf)
    since = [ego for time, ego in egos if time >= begun - 1e-6]
    if not since:
        return False
    length = max(RouteFollower.CHANGE_LENGTH_MIN, RouteFollower.CHANGE_TIME * since[0].speed)
    driven = sum(math.hypot(after.x - before.x, after.y - before.y) for before, after in itertools.pairwise(since))
    return driven < length


def _at(kind: PlaceKind, place: RoutePlace, zone: Zone, front: float) -> IncidentPlace:
    return IncidentPlace(kind, place.stage, zone.rule.name.lower(), round(zone.begin - front, 2))


def _on_highway(route: Route, place: RoutePlace, descriptor: Descriptor) -> IncidentPlace:
    last = len(route.stages) - 1
    if descriptor.manoeuvre == "exit":
        return IncidentPlace("exit_lane" if place.stage == last else "highway", place.stage)
    if descriptor.manoeuvre == "merge" and place.stage == 0 and route.windows:
        return IncidentPlace("ramp" if place.position < route.windows[0].begin else "acceleration_lane", 0)
    return IncidentPlace("highway", place.stage)
