"""What a run is judged by: what it has in common with a crash, dimension by dimension."""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum

from roadmend.safe.contact import Contact, find_contacts
from roadmend.safe.crash_record import CrashRecord
from roadmend.safe.film import Film
from roadmend.safe.motion import Motion, motions_of
from roadmend.world.scenario import Scenario

_ANGLE = 50.0  # [deg] that a heading may be off a point of the compass: the scenario language has four of eight
STANDING = 1.5  # [m/s] at most of a vehicle that stood
BACKWARDS = 0.2  # [m/s] at least of one that went backwards


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
    contacts = tuple(find_contacts(film))
    impacts: dict[str, int] = {}
    for contact in contacts:
        if contact.names & film.fixed:
            for name in contact.names - film.fixed:
                impacts.setdefault(name, contact.tick)
    return Run(scenario, film, contacts, motions_of(film, impacts))


@dataclass(frozen=True, slots=True)
class Judgement:
    """What a run has of a crash.

    Attributes:
        failed: why, by the dimension that differs.
        shown: collisions of the record that the run shows.
        recorded: collisions that the record has: of two vehicles, or those of a vehicle that crashed alone.
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


Check = Callable[[Run, CrashRecord, Contact], str]  # of a run by a record, with the run's first contact; why it differs


def judgement_by(checks: Mapping[Likeness, Check], run: Run, record: CrashRecord, recorded: int) -> Judgement:
    """What a run in which somebody touched something has of a crash with ``recorded`` collisions."""
    found = {dimension: checks[dimension](run, record, run.contacts[0]) for dimension in Likeness}
    shown = 0 if found[Likeness.ORDER] else len(run.contacts)
    return Judgement({dimension: reason for dimension, reason in found.items() if reason}, shown, recorded)


def vehicle_name(number: int) -> str:
    """What a film calls the report's vehicle with a number."""
    return f"v{number}"


def in_degrees(angle: float) -> float:
    """An angle [rad] in degrees, from 0 up to 360."""
    return math.degrees(angle) % 360.0


def any_near(wanted: float, headings: Iterable[float]) -> bool:
    """Whether one of the headings [rad] is about a wanted one [deg]."""
    return any(abs(math.remainder(math.degrees(heading) - wanted, 360.0)) <= _ANGLE for heading in headings)
