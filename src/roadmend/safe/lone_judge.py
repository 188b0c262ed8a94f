"""Whether a run reproduces a crash of one vehicle alone, by the same dimensions as a crash of several.

The record says which part of which vehicle struck something, where that vehicle came from and went to, on which road, and
perhaps what it struck and to which side it left its way. Of what is struck, the kind counts as far as it decides how such a
crash goes: something upright beside the roadway (a tree for a pole), something along the road, a vehicle that stands there,
or something on the roadway. The ego is no vehicle of the record and must not touch anybody. A run shows the first of the
record's impacts, since a vehicle stands where it struck something.
"""

from collections.abc import Mapping

from roadmend.safe.contact import Contact
from roadmend.safe.crash_record import CrashRecord, RecordedThing
from roadmend.safe.likeness import BACKWARDS, STANDING, Check, Judgement, Likeness, Run, judgement_by, vehicle_name
from roadmend.safe.run_map import beside_its_way, is_on_roadway
from roadmend.safe.way_checks import check_destination, check_origin, check_physical, check_road
from roadmend.world.obstacle import ObstacleKind

THINGS: Mapping[ObstacleKind, RecordedThing] = {
    "tree": RecordedThing.UPRIGHT,
    "pole": RecordedThing.UPRIGHT,
    "sign": RecordedThing.UPRIGHT,
    "object": RecordedThing.UPRIGHT,
    "barrier": RecordedThing.ALONG_THE_ROAD,
    "wall": RecordedThing.ALONG_THE_ROAD,
    "ditch": RecordedThing.ALONG_THE_ROAD,
    "curb": RecordedThing.ALONG_THE_ROAD,
    "parked_vehicle": RecordedThing.VEHICLE,
    "animal": RecordedThing.ON_THE_ROADWAY,
    "debris": RecordedThing.ON_THE_ROADWAY,
}
_BESIDE = 1.0  # [m] at least from the middle of its lane to what a vehicle strikes that left its way


def judge_alone(run: Run, record: CrashRecord) -> Judgement:
    """Hold a run against the record of a crash in which no two vehicles touched."""
    if not run.contacts:
        return Judgement(dict.fromkeys(Likeness, "nobody struck anything"), 0, len(record.impacts))
    return judgement_by(_CHECKS, run, record, len(record.impacts))


def _striking(record: CrashRecord) -> str:
    return vehicle_name(record.impacts[0].striking)


def _who(run: Run, record: CrashRecord, first: Contact) -> str:
    name = _striking(record)
    if name not in first.names or not first.names & run.film.fixed:
        return f"{' and '.join(sorted(first.names))} met, while {name} struck something that is no vehicle"
    if abs(first.of(name).speed) <= STANDING:
        return f"{name} stood"
    wanted = record.impacts[0].thing
    kinds = [THINGS[each.kind] for each in run.scenario.obstacles if each.id in first.names]
    if wanted is not None and wanted not in kinds:
        return f"{name} struck something {' and '.join(kinds)}, not {wanted}"
    return ""


def _order(run: Run, record: CrashRecord, _first: Contact) -> str:
    for place, contact in enumerate(run.contacts):
        wanted = vehicle_name(record.impacts[place].striking) if place < len(record.impacts) else ""
        if wanted not in contact.names or not contact.names & run.film.fixed:
            between = " and ".join(sorted(contact.names))
            return f"contact {place + 1} is between {between}, which the record does not have there"
    return ""


def _parts(run: Run, record: CrashRecord, _first: Contact) -> str:
    for contact, wanted in zip(run.contacts, record.impacts, strict=False):
        name = vehicle_name(wanted.striking)
        if name in contact.names and wanted.striking_part is not None:
            touched = contact.of(name).part
            if not touched.is_near(wanted.striking_part):
                return f"{name} was touched at its {touched}, not its {wanted.striking_part}"
    return ""


def _origin(run: Run, record: CrashRecord, first: Contact) -> str:
    return check_origin(run, record, record.impacts[0].striking, first, first.tick)


def _destination(run: Run, record: CrashRecord, first: Contact) -> str:
    return check_destination(run, record, record.impacts[0].striking, first.tick)


def _road(run: Run, record: CrashRecord, first: Contact) -> str:
    wanted = record.impacts[0].on_roadway
    if wanted is not None and is_on_roadway(run.scenario.network, first.x, first.y) is not wanted:
        return f"it happened {'beside' if wanted else 'on'} the roadway"
    return check_road(run, record, first)


def _motion(run: Run, record: CrashRecord, first: Contact) -> str:
    vehicle, name = record.vehicle(record.impacts[0].striking), _striking(record)
    if name not in first.names:
        return ""
    if vehicle.reverses and first.of(name).speed > -BACKWARDS:
        return f"{name} did not go backwards"
    if vehicle.leaves and beside_its_way(run.scenario, name, first.x, first.y) * vehicle.leaves < _BESIDE:
        return f"{name} did not leave its way to the {'left' if vehicle.leaves > 0 else 'right'}"
    return ""


_CHECKS: Mapping[Likeness, Check] = {
    Likeness.WHO: _who,
    Likeness.ORDER: _order,
    Likeness.PARTS: _parts,
    Likeness.ORIGIN: _origin,
    Likeness.DESTINATION: _destination,
    Likeness.ROAD: _road,
    Likeness.MOTION: _motion,
    Likeness.PHYSICAL: check_physical,
}
