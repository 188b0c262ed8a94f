"""Whether a run reproduces a crash, decided from the run and a record of the crash alone.

Nothing here knows how the report was read: the run's own vehicles, contacts and map are held against the record,
dimension by dimension. The map's north is the record's north.

A run ends with the ego's first contact, so it can show the collisions of the record up to that one. The contacts of the
run have to be the first ones of the record, in its order; how many of the record's collisions that covers is part of
the judgement.
"""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum

from roadmend.core.tick import INTERVAL
from roadmend.safe.contact import Contact, Part, find_contacts
from roadmend.safe.crash_record import CrashRecord, RecordedCollision
from roadmend.safe.film import Film
from roadmend.safe.motion import Motion, motions_of
from roadmend.safe.run_map import heading_at_end, roads_at, stem_at
from roadmend.world.scenario import Scenario

_ANGLE = 50.0  # [deg] that a heading may be off a point of the compass: the scenario language has four of eight
_STANDING = 1.5  # [m/s] at most of a vehicle that stood
_BACKWARDS = 0.2  # [m/s] at least of one that went backwards
_MUTUAL = 0.5  # share of the faster approach from which on both run into each other
_APPROACH = 2.0  # [s] before a contact, when nobody had begun to turn away from it


class Likeness(StrEnum):
    """What a run has in common with the crash."""

    WHO = "who"  # the two that touch first, and which of them ran into the other
    ORDER = "order"  # all contacts are those of the record, one after the other
    PARTS = "parts"  # where on both vehicles; a corner next to the part counts
    ORIGIN = "from"  # headings before the crash
    DESTINATION = "to"  # headings that the vehicles were going to have
    ROAD = "road"  # type of road at the place
    MOTION = "motion"  # who stood, stands; who went backwards, goes backwards
    PHYSICAL = "physical"  # nobody moves as no vehicle can


@dataclass(frozen=True, slots=True)
class Run:
    """What there is to judge: a scenario and the film of it."""

    scenario: Scenario
    film: Film
    contacts: tuple[Contact, ...]
    motions: Mapping[str, Motion]


def run_of(scenario: Scenario, film: Film) -> Run:
    """Look for contacts and accelerations in a film."""
    return Run(scenario, film, tuple(find_contacts(film)), motions_of(film))


@dataclass(frozen=True, slots=True)
class Judgement:
    """What a run has of a crash.

    Attributes:
        failed: why, by the dimension that differs.
        shown: collisions of the record that the run shows.
        recorded: collisions between vehicles that the record has.
    """

    failed: Mapping[Likeness, str]
    shown: int
    recorded: int

    @property
    def is_reproduced(self) -> bool:
        """Whether nothing differs."""
        return not self.failed

    def is_reproduced_but_for(self, dropped: Likeness) -> bool:
        """Whether nothing else differs."""
        return not {*self.failed} - {dropped}


def judge(run: Run, record: CrashRecord) -> Judgement:
    """Hold a run against the record of a crash."""
    first = run.contacts[0] if run.contacts else None
    if first is None or not record.collisions:
        reason = "nobody touched anybody" if record.collisions else "the record has no collision of two vehicles"
        return Judgement(dict.fromkeys(Likeness, reason), 0, len(record.collisions))
    found = {dimension: _CHECKS[dimension](run, record, first) for dimension in Likeness}
    shown = 0 if found[Likeness.ORDER] else len(run.contacts)
    return Judgement(
        {dimension: reason for dimension, reason in found.items() if reason}, shown, len(record.collisions)
    )


def _who(_run: Run, record: CrashRecord, first: Contact) -> str:
    wanted = record.collisions[0]
    if first.names != _names(wanted):
        return f"{_pair(first.names)} met, not {_pair(_names(wanted))}"
    fronts = [each for each in (wanted.striking_part, wanted.struck_part) if each is not None]
    if len(fronts) == 2 and all(each.is_near(Part.FRONT) for each in fronts):
        return ""  # front to front neither is the one
    striking, struck = first.of(_name(wanted.striking)), first.of(_name(wanted.struck))
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
            touched = contact.of(_name(number)).part
            if part is not None and not touched.is_near(part):
                return f"{_name(number)} was touched at its {touched}, not its {part}"
    return ""


def _origin(run: Run, record: CrashRecord, first: Contact) -> str:
    for number in _involved(run, record):
        wanted = record.vehicle(number).origin
        track = run.film.track(_name(number))
        if wanted is None or not len(track):
            continue
        backwards = math.pi if record.vehicle(number).reverses else 0.0
        headings = [track[0, 3] + backwards]
        if "Curve" in roads_at(run.scenario.network, first.x, first.y):
            # In a bend a report may name the direction before it or the one at the place.
            headings.append(track[max(0, len(track) - 1 - round(_APPROACH / INTERVAL)), 3] + backwards)
        if not _any_near(wanted, headings):
            return f"{_name(number)} came heading {_degrees(headings[0]):.0f} deg, not {wanted:.0f}"
    return ""


def _destination(run: Run, record: CrashRecord, _first: Contact) -> str:
    for number in _involved(run, record):
        wanted = record.vehicle(number).destination
        track = run.film.track(_name(number))
        if wanted is None or not len(track):
            continue
        is_ego = _name(number) == run.film.ego_name
        headings = heading_at_end(run.scenario, None if is_ego else _name(number))
        backwards = math.pi if record.vehicle(number).reverses else 0.0
        if not _any_near(wanted, [heading + backwards for heading in headings]):
            return f"{_name(number)} was going to head {_degrees(headings[-1]):.0f} deg, not {wanted:.0f}"
    return ""


def _road(run: Run, record: CrashRecord, first: Contact) -> str:
    found = roads_at(run.scenario.network, first.x, first.y)
    if record.roads and not found & {*record.roads}:
        return f"the place is of type {' or '.join(sorted(found))}, not {' or '.join(record.roads)}"
    stem = stem_at(run.scenario.network)
    if record.stem is not None and stem is not None and not _any_near(record.stem, [stem]):
        return f"the stem lies at {_degrees(stem):.0f} deg, not {record.stem:.0f}"
    return ""


def _motion(run: Run, record: CrashRecord, _first: Contact) -> str:
    for contact, wanted in _compared(run, record):
        for number in (wanted.striking, wanted.struck):
            vehicle, touch = record.vehicle(number), contact.of(_name(number))
            if number == wanted.struck and vehicle.stands and abs(touch.speed) > _STANDING:
                return f"{touch.name} had {touch.speed:.1f} m/s and should have stood"
            if vehicle.reverses and touch.speed > -_BACKWARDS:
                return f"{touch.name} did not go backwards"
    return ""


def _physical(run: Run, _record: CrashRecord, _first: Contact) -> str:
    for name, motion in run.motions.items():
        if not motion.is_physical:
            return f"{name} had {motion.longitudinal:.1f} m/s2 along and {motion.lateral:.1f} m/s2 across its way"
    return ""


_CHECKS: Mapping[Likeness, Callable[[Run, CrashRecord, Contact], str]] = {
    Likeness.WHO: _who,
    Likeness.ORDER: _order,
    Likeness.PARTS: _parts,
    Likeness.ORIGIN: _origin,
    Likeness.DESTINATION: _destination,
    Likeness.ROAD: _road,
    Likeness.MOTION: _motion,
    Likeness.PHYSICAL: _physical,
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


def _name(number: int) -> str:
    return f"v{number}"


def _names(collision: RecordedCollision) -> frozenset[str]:
    return frozenset({_name(collision.striking), _name(collision.struck)})


def _pair(names: frozenset[str]) -> str:
    return " and ".join(sorted(names))


def _degrees(angle: float) -> float:
    return math.degrees(angle) % 360.0


def _any_near(wanted: float, headings: Iterable[float]) -> bool:
    """Whether one of the headings [rad] is about a wanted one [deg]."""
    return any(abs(math.remainder(math.degrees(heading) - wanted, 360.0)) <= _ANGLE for heading in headings)
