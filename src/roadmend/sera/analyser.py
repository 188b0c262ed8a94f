"""From incidents to failure patterns: the interface, and the embedded analyser that needs no language model."""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from typing import Protocol, TypeVar

from roadmend.sera.descriptor import HazardKind
from roadmend.sera.incident import OUTCOMES, Incident
from roadmend.sera.incident_words import note_of_incident, words_of_incident
from roadmend.sera.pattern import FailurePattern, PatternEvidence, Where, Who, Why

Value = TypeVar("Value")


class Analyser(Protocol):
    """Groups incidents into patterns."""

    name: str

    def analyse(self, incidents: Sequence[Incident]) -> tuple[FailurePattern, ...]:
        """The patterns, those with most evidence first; every incident is evidence of exactly one."""


class EmbeddedAnalyser:
    """Groups what agrees in what happened, where, in which manoeuvre of the ego, with whom and how they met.

    Deterministic; the order of the incidents does not matter.
    """

    name = "embedded"

    def analyse(self, incidents: Sequence[Incident]) -> tuple[FailurePattern, ...]:
        """The patterns, those with most evidence first."""
        groups: dict[str, list[Incident]] = defaultdict(list)
        for incident in in_order(incidents):
            groups[_key(incident)].append(incident)
        patterns = [pattern_of(key, group) for key, group in groups.items()]
        return tuple(sorted(patterns, key=lambda pattern: (-len(pattern.evidence), pattern.name)))


def in_order(incidents: Sequence[Incident]) -> list[Incident]:
    """The same order, whatever order they come in."""
    return sorted(incidents, key=lambda one: (one.bag, one.time, one.kind))


def pattern_of(name: str, incidents: Sequence[Incident]) -> FailurePattern:
    """The pattern that incidents show together: of structure, what holds for all of them."""
    wheres = [incident.where for incident in incidents]
    others = [incident.other for incident in incidents]
    known = [other for other in others if other is not None]
    complete = known if len(known) == len(others) else []
    return FailurePattern(
        name=name,
        words=words_of_incident(incidents[0]),
        what=OUTCOMES[incidents[0].kind],
        where=Where(
            family=_common(where.family for where in wheres),
            road=_common(where.road for where in wheres),
            control=_common(where.control for where in wheres),
            lanes=_common(where.lanes for where in wheres),
            speed_limit=_common(where.speed_limit for where in wheres),
            density=_common(where.density for where in wheres),
            weather=_common(where.weather for where in wheres),
            light=_common(where.light for where in wheres),
        ),
        who=Who(
            participant=_common(other.kind for other in complete),
            side=_common(other.side for other in complete),
            driver=_common(other.driver for other in complete),
        ),
        why=Why(
            manoeuvre=_common(incident.ego.manoeuvre for incident in incidents),
            hazard=_common_hazard([other.hazard for other in complete]),
        ),
        evidence=tuple(
            PatternEvidence(incident.bag, incident.scenario, incident.time, note_of_incident(incident))
            for incident in incidents
        ),
    )


def _key(incident: Incident) -> str:
    other = incident.other
    parts = [
        incident.kind,
        incident.where.road or "road",
        incident.place.kind,
        incident.ego.action,
        *([] if other is None else [other.kind or "participant", other.encounter]),
    ]
    return "/".join(parts)


def _common_hazard(hazards: Sequence[HazardKind | None]) -> HazardKind | None:
    """The hazard of all; who cuts in and brakes cuts in."""
    if set(hazards) == {"cut_in", "cut_in_and_brake"}:
        return "cut_in"
    return _common(hazards)


def _common(values: Iterable[Value | None]) -> Value | None:
    """The value that all have; None where they differ."""
    found = list(values)
    return found[0] if found and all(value == found[0] for value in found) else None
