"""Whether a run reproduces a crash, decided from the run and a record of the crash alone.

Nothing here knows how the report was read: the run's own vehicles, contacts and map are held against the record,
dimension by dimension. The map's north is the record's north.

A run ends with the ego's first contact, so it can show the collisions of the record up to that one. The contacts of the
run have to be the first ones of the record, in its order; how many of the record's collisions that covers is part of
the judgement. A vehicle that crashed alone is judged in ``lone_judge``.
"""

from collections.abc import Iterable, Mapping

from roadmend.safe.contact import Contact, Part
from roadmend.safe.crash_record import CrashRecord, RecordedCollision
from roadmend.safe.likeness import BACKWARDS, STANDING, Check, Judgement, Likeness, Run, judgement_by, vehicle_name
from roadmend.safe.lone_judge import judge_alone
from roadmend.safe.way_checks import check_destination, check_origin, check_physical, check_road

_MUTUAL = 0.5  # share of the faster approach from which on both run into each other


def judge(run: Run, record: CrashRecord) -> Judgement:
    """Hold a run against the record of a crash."""
    if record.is_alone:
        return judge_alone(run, record)
    if not run.contacts or not record.collisions:
        reason = "nobody touched anybody" if record.collisions else "the record has no collision of two vehicles"
        return Judgement(dict.fromkeys(Likeness, reason), 0, len(record.collisions))
    return judgement_by(_CHECKS, run, record, len(record.collisions))


def _who(_run: Run, record: CrashRecord, first: Contact) -> str:
    wanted = record.collisions[0]
    if first.names != _names(wanted):
        return f"{_pair(first.names)} met, not {_pair(_names(wanted))}"
    fronts = [each for each in (wanted.striking_part, wanted.struck_part) if each is not None]
    if len(fronts) == 2 and all(each.is_near(Part.FRONT) for each in fronts):
        return ""  # front to front neither is the one
    striking, struck = first.of(vehicle_name(wanted.striking)), first.of(vehicle_name(wanted.struck))
    if max(striking.approach, 0.0) < _MUTUAL * struck.approach:
        return f"{struck.name} ran into {striking.name}, not the other way round"
    return ""


def _order(run: Run, record: CrashRecord, _first: Contact) -> str:
    wanted = [_names(each) for each in record.collisions]
    for place, contact in enumerate(run.contacts):
        if place >= len(wanted) or contact.names != wanted[place]:
            return f"contact {place + 1} is between {_pair(contact.names)}, which the record does not have there"
    return ""


def _parts(run: Run, record: CrashRecord, _first: Contact) -> str:
    for contact, wanted in _compared(run, record):
        for number, part in ((wanted.striking, wanted.striking_part), (wanted.struck, wanted.struck_part)):
            touched = contact.of(vehicle_name(number)).part
            if part is not None and not touched.is_near(part):
                return f"{vehicle_name(number)} was touched at its {touched}, not its {part}"
    return ""


def _origin(run: Run, record: CrashRecord, first: Contact) -> str:
    last = len(run.film.ego) - 1
    return next(filter(None, (check_origin(run, record, each, first, last) for each in _involved(run, record))), "")


def _destination(run: Run, record: CrashRecord, _first: Contact) -> str:
    return next(filter(None, (check_destination(run, record, each) for each in _involved(run, record))), "")


def _motion(run: Run, record: CrashRecord, _first: Contact) -> str:
    for contact, wanted in _compared(run, record):
        for number in (wanted.striking, wanted.struck):
            vehicle, touch = record.vehicle(number), contact.of(vehicle_name(number))
            if number == wanted.struck and vehicle.stands and abs(touch.speed) > STANDING:
                return f"{touch.name} had {touch.speed:.1f} m/s and should have stood"
            if vehicle.reverses and touch.speed > -BACKWARDS:
                return f"{touch.name} did not go backwards"
    return ""


_CHECKS: Mapping[Likeness, Check] = {
    Likeness.WHO: _who,
    Likeness.ORDER: _order,
    Likeness.PARTS: _parts,
    Likeness.ORIGIN: _origin,
    Likeness.DESTINATION: _destination,
    Likeness.ROAD: check_road,
    Likeness.MOTION: _motion,
    Likeness.PHYSICAL: check_physical,
}


def _compared(run: Run, record: CrashRecord) -> Iterable[tuple[Contact, RecordedCollision]]:
    """The contacts that are between the same two as the record's collision in the same place of the order."""
    for contact, wanted in zip(run.contacts, record.collisions, strict=False):
        if contact.names == _names(wanted):
            yield contact, wanted


def _involved(run: Run, record: CrashRecord) -> list[int]:
    """Numbers of the vehicles in those collisions of the record that the run can show."""
    numbers = [
        number for each in record.collisions[: max(1, len(run.contacts))] for number in (each.striking, each.struck)
    ]
    return [*dict.fromkeys(numbers)]


def _names(collision: RecordedCollision) -> frozenset[str]:
    return frozenset({vehicle_name(collision.striking), vehicle_name(collision.struck)})


def _pair(names: frozenset[str]) -> str:
    return " and ".join(sorted(names))
