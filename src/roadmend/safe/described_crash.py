"""What a reading of a report says of its crash, in the form that a run is judged by; and which roles can be played.

The search for a crash aims at this; it is not what decides whether the crash was reproduced (see ``judge``).
"""

import math
from dataclasses import replace

from roadmend.safe.compass import BEARING, HEADING, TURN
from roadmend.safe.contact import Part
from roadmend.safe.crash_record import (
    CrashRecord,
    RecordedCollision,
    RecordedImpact,
    RecordedManoeuvre,
    RecordedVehicle,
)
from roadmend.safe.departure import THINGS
from roadmend.safe.dsl import (
    ON_THE_ROADWAY,
    STANDING,
    Action,
    CrashScenario,
    DescribedImpact,
    DescribedVehicle,
    Manoeuvre,
    Position,
    RoadType,
    Side,
)
from roadmend.safe.lone_judge import THINGS as RECORDED
from roadmend.safe.staging import collisions_of, first_collision, is_alone
from roadmend.safe.ways import Layout

_PART = {side: Part(side.value.lower()) for side in Side}
# What no policy does on its own account, so that it cannot take the place of who did.
_NOT_PLAYED = {
    *(Manoeuvre.ENTER_THE_WRONG_WAY, Manoeuvre.CHANGING_LANE, Manoeuvre.OVERTAKE),
    *(Manoeuvre.U_TURN, Manoeuvre.REVERSE, Manoeuvre.RUN_OFF),
}
_RECORDED = {  # of what a vehicle does, as far as a judge asks for it beside where it comes from and goes to
    Manoeuvre.STOP: RecordedManoeuvre.STOP,
    Manoeuvre.PARKED: RecordedManoeuvre.PARKED,
    Manoeuvre.REVERSE: RecordedManoeuvre.REVERSE,
}


_LEAVES = {Side.LEFT: RecordedManoeuvre.DRIFT_LEFT, Side.RIGHT: RecordedManoeuvre.DRIFT_RIGHT}


def why_not_played(crash: CrashScenario, ego: int | None) -> str:
    """Why the crash cannot happen as described with the policy in a vehicle's place; empty if it can.

    Where it looks on (None), a vehicle crashes alone that has to go forwards.
    """
    if is_alone(crash) and ego is not None:
        return "a single vehicle: the ego, which does not leave its road, can only look on"
    if ego is None:
        manoeuvre = crash.vehicles[0].manoeuvre
        stays = manoeuvre in {*STANDING, Manoeuvre.REVERSE}
        return f"a vehicle alone that does not go forwards ({manoeuvre})" if stays else ""
    first = first_collision(crash)
    if first is not None and ego + 1 not in {first.striking, first.struck}:
        return "the vehicle is not in the first collision of the report"
    manoeuvre = crash.vehicles[ego].manoeuvre
    joins = manoeuvre is Manoeuvre.MERGE and crash.road.road_type is not RoadType.MERGING
    if joins or manoeuvre in _NOT_PLAYED:
        return f"the vehicle does what no policy is asked to do here ({manoeuvre})"
    return ""


def record_of(crash: CrashScenario, layout: Layout | None = None, ego: int = 0) -> CrashRecord:
    """A reading of a report as a record, so that a run can be held against it.

    Args:
        crash: as the report has it.
        layout: that a scenario was built with; headings and turns come from it where it is given.
        ego: whom the collisions concern, where the report names none: then it may be with anybody.
    """
    collisions = tuple(
        RecordedCollision(
            each.striking,
            each.struck,
            _PART.get(each.striking_side) if each.striking_side else None,
            _PART.get(each.struck_side) if each.struck_side else None,
        )
        for each in crash.collisions or collisions_of(crash, ego)
    )
    vehicles = tuple(_vehicle(number, each) for number, each in enumerate(crash.vehicles, 1))
    impacts = tuple(_impact(each) for each in crash.impacts)
    if is_alone(crash):
        impacts = impacts or (RecordedImpact(1),)
        side = _LEAVES.get(crash.impacts[0].roadside) if crash.impacts and crash.impacts[0].roadside else None
        vehicles = tuple(replace(each, manoeuvre=side) for each in vehicles)
        collisions = ()
    roads = (crash.road.road_type.value,) if crash.road.road_type is not None else ()
    stem = float(BEARING[crash.road.stem]) if crash.road.stem is not None else None
    if layout is not None and layout.adapted:
        roads, stem = (), None  # the report contradicts itself there, and the scenario says so
    return CrashRecord("", roads, vehicles, collisions, stem, len(collisions) + len(impacts), impacts)


def _impact(impact: DescribedImpact) -> RecordedImpact:
    part = _PART.get(impact.striking_side) if impact.striking_side else None
    if impact.object is None:
        return RecordedImpact(impact.striking, part)
    return RecordedImpact(impact.striking, part, RECORDED[THINGS[impact.object].kind], impact.object in ON_THE_ROADWAY)


def _vehicle(number: int, vehicle: DescribedVehicle) -> RecordedVehicle:
    manoeuvre = _RECORDED.get(vehicle.manoeuvre) if vehicle.manoeuvre else None
    if vehicle.initial_position in {None, Position.MAIN_ROAD, Position.ON_RAMP}:
        return RecordedVehicle(number, None, None, manoeuvre)
    assert vehicle.initial_position is not None
    heading = float(HEADING[vehicle.initial_position])
    to = None
    if isinstance(vehicle.action, Action):
        # Who turns round goes back the way it came, though the language knows that as a turn to the left.
        turn = 180.0 if vehicle.manoeuvre is Manoeuvre.U_TURN else TURN[vehicle.action]
        to = math.remainder(heading + turn, 360.0)
    return RecordedVehicle(number, heading, to, manoeuvre)
