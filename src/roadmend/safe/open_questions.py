"""What a crash report leaves open, as a space that scenarios are drawn from, and the report with it filled in."""

from collections.abc import Iterable
from dataclasses import replace

from roadmend.core.errors import InputError
from roadmend.safe.compass import DIRECTIONS, NORTH_SOUTH, TOWARDS, heading_of, opposite, origin_of
from roadmend.safe.dsl import (
    STANDING,
    Action,
    Compass,
    CrashScenario,
    DescribedEnvironment,
    DescribedVehicle,
    DslModel,
    Manoeuvre,
    Position,
    RoadType,
    Time,
    Weather,
)
from roadmend.safe.staging import is_alone, is_struck_from_behind
from roadmend.safe.stated import bend_side, control_of
from roadmend.world.space import Choice, Dimension, Parameters, Uniform, Value, Whole

_JUNCTIONS = {RoadType.INTERSECTION, RoadType.T_INTERSECTION}
_MODELS = Choice({"Sedan": 0.45, "SUV": 0.25, "Minivan": 0.08, "Pickup": 0.17, "Semi Truck": 0.05})
_WEATHER = Choice({"Clear": 0.35, "Cloudy": 0.25, "Overcast": 0.1, "Rainy": 0.2, "Foggy": 0.05, "Snowy": 0.05})
_TURNS = {Manoeuvre.TURN_LEFT: Action.TURN_LEFT, Manoeuvre.TURN_RIGHT: Action.TURN_RIGHT}
_WAITS = 0.7  # share of those struck from behind that stand: most rear-end crashes are with a stopped vehicle
_LIMITS: dict[RoadType, tuple[int, ...]] = {  # [mph]
    RoadType.STRAIGHT: (35, 45, 55),
    RoadType.CURVE: (35, 45, 55),
    RoadType.INTERSECTION: (25, 35, 45),
    RoadType.T_INTERSECTION: (25, 35, 45),
    RoadType.MERGING: (55, 65, 70),
}


def open_questions(crash: CrashScenario) -> dict[str, Dimension]:
    """The dimensions of all that a report leaves open: its null fields, and what the language has no field for."""
    space: dict[str, Dimension] = {}
    kinds = [crash.road.road_type] if crash.road.road_type is not None else _likely_types(crash)
    if crash.road.road_type is None:
        space["road_type"] = _even(kind.value for kind in kinds)
    if crash.road.lanes is None:
        space["lanes"] = Choice({2: 0.5, 4: 0.4, 6: 0.1})
    if crash.road.stem is None and RoadType.T_INTERSECTION in kinds:
        space["stem"] = _even(side.value for side in _possible_stems(crash))
    if crash.environment.time is None:
        space["time"] = Choice({Time.DAYTIME.value: 0.65, Time.NIGHTTIME.value: 0.35})
    if crash.environment.weather is None:
        space["weather"] = _WEATHER
    for number, vehicle in enumerate(crash.vehicles, start=1):
        space |= _of_vehicle(f"v{number}", vehicle, crash, kinds)
        if is_struck_from_behind(crash, number - 1) and vehicle.manoeuvre not in STANDING:
            # "Move Forward" is all that the paper's language has for who waits in a queue, or to turn.
            space[f"v{number}.waits"] = Choice({"yes": _WAITS, "no": 1.0 - _WAITS})
    if is_alone(crash):
        space |= _of_departure()
    if kinds != [RoadType.MERGING]:  # a straight road too may turn out to need a side road
        control: dict[Value, float] = {"first_major": 0.25, "other_major": 0.25}
        if control_of(crash) is None:  # else only which road is the major one
            control |= {"allway_stop": 0.15, "traffic_light": 0.35}
        space["control"] = Choice(control)
        space["phase"] = _even((0, 20))  # [s] of a traffic light's cycle of 40 s: either road may have green first
        space["crossing_road"] = Choice({"as_large": 0.5, "two_lanes": 0.5})
    if RoadType.CURVE in kinds:
        if bend_side(crash) is None:
            space["bend"] = _even(("left", "right"))
        space["bend_angle"] = _even((30, 45, 60, 75))
        space["bend_radius"] = _even((80, 120, 160))
    if RoadType.MERGING in kinds:
        space |= {"ramp_length": _even((140, 180)), "lane_length": _even((160, 220, 280))}
    return space


def _of_vehicle(
    name: str, vehicle: DescribedVehicle, crash: CrashScenario, kinds: list[RoadType]
) -> dict[str, Dimension]:
    space: dict[str, Dimension] = {}
    if vehicle.model is None:
        space[f"{name}.model"] = _MODELS
    if vehicle.initial_position is None:
        space[f"{name}.position"] = _positions(crash, kinds)
    if _action(vehicle) is None:
        may_turn = bool(_JUNCTIONS & {*kinds}) and vehicle.manoeuvre in {None, *STANDING}
        weights: dict[Value, float] = {"Move Forward": 0.7, "Turn Left": 0.2, "Turn Right": 0.1}
        space[f"{name}.action"] = Choice(weights if may_turn else {"Move Forward": 1.0})
    if vehicle.speed_limit_mph is None:
        known = {other.speed_limit_mph for other in crash.vehicles if other.speed_limit_mph is not None}
        limits = sorted(known) if known else sorted({limit for kind in kinds for limit in _LIMITS[kind]})
        space[f"{name}.speed_limit"] = _even(limits)
    return space | {
        f"{name}.lane": Uniform(0.0, 1.0),  # share, from the right
        f"{name}.time": Uniform(3.0, 6.0),  # [s] from the start to the place of the crash, where it is the ego
        f"{name}.speed": Uniform(0.6, 1.25),  # share of the limit
        f"{name}.turning_speed": Uniform(4.0, 9.0),  # [m/s]
        f"{name}.delay": Uniform(-2.5, 2.5),  # [s] behind the ego at the place of the crash
        f"{name}.start": Choice({"rolling": 0.55, "from_stop": 0.45}),  # at a junction, where another one is the ego
        f"{name}.heed": Choice({"none": 0.8, "normal": 0.2}),
        f"{name}.order": Choice({"ahead": 0.4, "behind": 0.6}),  # of the ego, where both go the same way
        f"{name}.closing": Uniform(3.0, 12.0),  # [m/s] faster than the ego where it comes from behind
        f"{name}.braking": Uniform(4.0, 8.0),  # [m/s2]
        f"{name}.drift_time": Uniform(0.8, 2.5),  # [s] that leaving the lane takes
        f"{name}.side": Whole(0, 1),  # of the ego: right or left, where both go the same way
    }


def _of_departure() -> dict[str, Dimension]:
    """How a vehicle leaves its road that crashes alone, and where the onlooker is."""
    return {
        "v1.depart_angle": Uniform(5.0, 14.0),  # [deg] to its lane
        "v1.clearance": Uniform(0.4, 2.5),  # [m] of what it strikes from the roadway
        "onlooker": Choice({"behind": 0.7, "oncoming": 0.3}),  # oncoming where the road has lanes for that
        "onlooker.gap": Uniform(1.2, 3.5),  # [s] behind it
        "onlooker.delay": Uniform(0.5, 4.0),  # [s] after the crash that one who comes the other way is there
    }


def answer(crash: CrashScenario, drawn: Parameters) -> CrashScenario:
    """The report with every null field filled in from a point of :func:`open_questions`.

    Raises:
        InputError: a vehicle's position or stem does not go with the road that was drawn.
    """
    road = replace(
        crash.road,
        road_type=crash.road.road_type or RoadType(str(drawn["road_type"])),
        lanes=crash.road.lanes or int(drawn["lanes"]),
    )
    if road.road_type is RoadType.T_INTERSECTION:
        road = replace(road, stem=crash.road.stem or Compass(str(drawn["stem"])))
    vehicles = tuple(
        replace(
            vehicle,
            model=vehicle.model or DslModel(str(drawn[f"v{number}.model"])),
            initial_position=vehicle.initial_position or Position(str(drawn[f"v{number}.position"])),
            action=_action(vehicle) or Action(str(drawn[f"v{number}.action"])),
            speed_limit_mph=vehicle.speed_limit_mph or float(drawn[f"v{number}.speed_limit"]),
        )
        for number, vehicle in enumerate(crash.vehicles, start=1)
    )
    environment = DescribedEnvironment(
        crash.environment.time or Time(str(drawn["time"])),
        crash.environment.weather or Weather(str(drawn["weather"])),
        crash.environment.extras,
    )
    try:
        return replace(crash, road=road, vehicles=vehicles, environment=environment)
    except ValueError as error:
        raise InputError("crash report", str(error), "mend the field") from None


def _action(vehicle: DescribedVehicle) -> Action | None:
    """The action, which a manoeuvre that turns tells too; a list of points counts as the turn that it makes."""
    if vehicle.action is None:
        return None if vehicle.manoeuvre is None else _TURNS.get(vehicle.manoeuvre)
    if not isinstance(vehicle.action, tuple):
        return vehicle.action
    turn = heading_of(vehicle.action[-2], vehicle.action[-1], heading_of(vehicle.action[0], vehicle.action[1]))
    if abs(turn) < 45.0:
        return Action.MOVE_FORWARD
    return Action.TURN_LEFT if turn > 0.0 else Action.TURN_RIGHT


def _likely_types(crash: CrashScenario) -> list[RoadType]:
    """Road types that go with what is known of the vehicles."""
    positions = {vehicle.initial_position for vehicle in crash.vehicles} - {None}
    if positions & {Position.MAIN_ROAD, Position.ON_RAMP}:
        return [RoadType.MERGING]
    axes = {position in NORTH_SOUTH for position in positions}
    turns = any(_action(vehicle) in {Action.TURN_LEFT, Action.TURN_RIGHT} for vehicle in crash.vehicles)
    if turns or len(axes) > 1:
        return [RoadType.INTERSECTION, RoadType.T_INTERSECTION]
    return [RoadType.STRAIGHT, RoadType.CURVE]


def _possible_stems(crash: CrashScenario) -> list[Compass]:
    """Stems that leave every vehicle the road that it comes from; all if there is none."""
    known = [(v.initial_position, _action(v)) for v in crash.vehicles if v.initial_position in TOWARDS]
    needed = {origin_of(position) for position, _ in known}
    needed |= {TOWARDS[position] for position, action in known if action is Action.MOVE_FORWARD}
    free = {origin_of(position) for position in DIRECTIONS if TOWARDS[position] not in needed}
    possible = [stem for stem in Compass if stem in free]
    return possible or [*Compass]


def _positions(crash: CrashScenario, kinds: list[RoadType]) -> Choice:
    """Where a vehicle may come from: on a road without a junction, the two directions that others have."""
    if RoadType.MERGING in kinds:
        return Choice({Position.MAIN_ROAD.value: 0.6, Position.ON_RAMP.value: 0.4})
    if _JUNCTIONS & {*kinds}:
        return _even(position.value for position in DIRECTIONS)
    known = [v.initial_position for v in crash.vehicles if v.initial_position in DIRECTIONS]
    first = known[0] if known else Position.W2E
    assert first is not None
    return Choice({first.value: 0.6, opposite(first).value: 0.4})


def _even(values: Iterable[Value]) -> Choice:
    return Choice(dict.fromkeys(values, 1.0))
