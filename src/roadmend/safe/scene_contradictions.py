"""What cannot be true at once in a scene: roads, ways, contacts and light held against each other."""

from collections.abc import Iterator
from dataclasses import dataclass

from roadmend.safe.compass import HEADING, NORTH_SOUTH, TOWARDS, TURN, origin_of, turned, wrap_degrees
from roadmend.safe.dsl import (
    Action,
    Compass,
    CrashScenario,
    DescribedVehicle,
    Manoeuvre,
    RoadType,
    Side,
    Time,
    Weather,
)

_JUNCTIONS = frozenset({RoadType.INTERSECTION, RoadType.T_INTERSECTION})
_SLACK = 25.0  # [deg] by which a heading may differ from that of the road before somebody must have lost control
_REAR_WITHIN = 100.0  # [deg] between two ways of which one can still run into the other's rear
_FRONT_BEYOND = 40.0  # [deg] between two ways that can still meet front to front
_ON = frozenset({None, Manoeuvre.MOVE_FORWARD})
_OF_TURNS = {Action.TURN_LEFT: Side.LEFT, Action.TURN_RIGHT: Side.RIGHT}


@dataclass(frozen=True, slots=True)
class Contradiction:
    """Statements of a scenario that exclude each other.

    Attributes:
        fields: that make them, as the JSON form calls them ("vehicles[0].action").
        reason: why they do, in words of the scenario language.
    """

    fields: tuple[str, ...]
    reason: str


def contradictions(scenario: CrashScenario) -> list[Contradiction]:
    """All of a scenario; what is open contradicts nothing.

    Only what excludes each other without a vehicle spinning is said of contacts, and only of the first of a vehicle:
    after it a vehicle stands anyhow.
    """
    return [
        *_of_light(scenario),
        *_of_manoeuvres(scenario),
        *_of_road(scenario),
        *_of_stem(scenario),
        *_of_partners(scenario),
        *_of_contacts(scenario),
    ]


def _of_light(scenario: CrashScenario) -> Iterator[Contradiction]:
    environment = scenario.environment
    if environment.time is Time.NIGHTTIME and environment.weather is Weather.SUNNY:
        yield Contradiction(("env.time", "env.weather"), "the sun does not shine at night")


def _of_manoeuvres(scenario: CrashScenario) -> Iterator[Contradiction]:
    for index, vehicle in enumerate(scenario.vehicles):
        manoeuvre = vehicle.manoeuvre
        if manoeuvre is None or not isinstance(vehicle.action, Action) or manoeuvre.value not in [*Action]:
            continue
        if manoeuvre.value != vehicle.action.value:
            fields = (f"vehicles[{index}].action", f"vehicles[{index}].manoeuvre")
            yield Contradiction(fields, f"{manoeuvre} as a manoeuvre is not {vehicle.action} as an action")


def _of_road(scenario: CrashScenario) -> Iterator[Contradiction]:
    """Vehicles of crossing ways on a road that no other one meets: one of them must have turned from or to elsewhere."""
    if scenario.road.road_type is not RoadType.STRAIGHT:
        return
    known = [vehicle for vehicle in scenario.vehicles if vehicle.initial_position in TOWARDS]
    axes = {vehicle.initial_position in NORTH_SOUTH for vehicle in known}
    goes_on = all(vehicle.action is Action.MOVE_FORWARD and vehicle.manoeuvre in _ON for vehicle in known)
    if len(axes) == 2 and goes_on:
        fields = ("road_type", *_all(scenario, "initial_position"), *_all(scenario, "action"))
        yield Contradiction(fields, "vehicles of crossing directions that all go straight on meet at a junction only")


def _of_stem(scenario: CrashScenario) -> Iterator[Contradiction]:
    stem = scenario.road.stem
    if scenario.road.road_type is not RoadType.T_INTERSECTION or stem is None:
        return
    is_alone = len(scenario.vehicles) == 1  # and may well have run on where no road is
    missing = _facing(stem)
    for index, vehicle in enumerate(scenario.vehicles):
        position = vehicle.initial_position
        if position not in TOWARDS or position is None:
            continue
        place = f"vehicles[{index}].initial_position"
        if origin_of(position) is missing:
            reason = (
                f"{position} comes from the {missing}, where a T-intersection with its stem in the {stem} has no leg"
            )
            yield Contradiction(("stem_direction", place), reason)
        elif _leads(vehicle) is missing and not is_alone:
            reason = f"{position} with {vehicle.action} leads {missing}, where a stem in the {stem} leaves no leg"
            yield Contradiction(("stem_direction", place, f"vehicles[{index}].action"), reason)


def _leads(vehicle: DescribedVehicle) -> Compass | None:
    if vehicle.initial_position not in TOWARDS or not isinstance(vehicle.action, Action):
        return None
    return TOWARDS[turned(vehicle.initial_position, _OF_TURNS.get(vehicle.action))]


def _facing(side: Compass) -> Compass:
    return next(TOWARDS[position] for position in TOWARDS if origin_of(position) is side)


def _of_partners(scenario: CrashScenario) -> Iterator[Contradiction]:
    """A scenario holds the vehicles that touched: each of them touches another one."""
    if not scenario.collisions or len(scenario.vehicles) == 1:
        return
    touched = {number for each in scenario.collisions for number in (each.striking, each.struck)}
    for number in range(1, len(scenario.vehicles) + 1):
        if number not in touched:
            yield Contradiction(("vehicles", "collisions"), f"vehicle {number} has no part in any collision")


def _of_contacts(scenario: CrashScenario) -> Iterator[Contradiction]:
    moved: set[int] = set()
    for index, collision in enumerate(scenario.collisions):
        pair = (collision.striking, collision.struck)
        was_moved = bool(moved & {*pair})
        moved |= {*pair}
        if was_moved or collision.struck_side is None or collision.striking_side not in {None, Side.FRONT}:
            continue
        ways = [_headings(scenario.vehicles[number - 1]) for number in pair]
        if not ways[0] or not ways[1]:
            continue
        slack = _SLACK if scenario.road.road_type in _JUNCTIONS else 2 * _SLACK
        angles = [wrap_degrees(one - other) for one in ways[0] for other in ways[1]]
        if any(_meets(angle, collision.struck_side, slack) for angle in angles):
            continue
        fields = [f"collisions[{index}].{name}" for name in ("striking", "struck", "struck_side")]
        fields += [f"vehicles[{number - 1}].{name}" for number in pair for name in ("initial_position", "action")]
        one, other = pair
        reason = (
            f"the front of vehicle {one} cannot meet the {collision.struck_side} of vehicle {other}, "
            f"as they come {_way(scenario, one)} and {_way(scenario, other)}"
        )
        yield Contradiction(tuple(fields), reason)


def _headings(vehicle: DescribedVehicle) -> list[float]:
    """Headings [deg] of a vehicle from before its turn to after it; none where they are not known."""
    position, action = vehicle.initial_position, vehicle.action
    if position is None or position not in TOWARDS or not isinstance(action, Action):
        return []
    return [HEADING[position] + share * TURN[action] for share in (0.0, 0.25, 0.5, 0.75, 1.0)]


def _meets(angle: float, side: Side, slack: float) -> bool:
    """Whether a front that comes at an angle [deg] to a vehicle's heading can touch a side of it."""
    if side is Side.REAR:
        return abs(angle) <= _REAR_WITHIN
    if side is Side.FRONT:
        return abs(angle) >= _FRONT_BEYOND - slack
    across = -angle if side is Side.LEFT else angle  # from the left it comes at a negative angle
    return -slack <= across <= 180.0 or across <= slack - 180.0


def _way(scenario: CrashScenario, number: int) -> str:
    vehicle = scenario.vehicles[number - 1]
    return f"{vehicle.initial_position} with {vehicle.action}"


def _all(scenario: CrashScenario, name: str) -> list[str]:
    return [f"vehicles[{index}].{name}" for index in range(len(scenario.vehicles))]
