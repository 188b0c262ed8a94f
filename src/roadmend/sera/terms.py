"""What descriptors and patterns are compared by: counted terms of a common vocabulary, and quantities.

A term is ``group:value``. What belongs together also stands together (``hazard+participant:cut_in+truck``), so that a
truck that cuts in is told from a truck beside a car that does. Words that no lexicon knows are terms as they are.
"""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import get_args

from roadmend.sera.descriptor import SUCCESS, Descriptor, HazardKind, OutcomeName, ParticipantKind, Side
from roadmend.sera.lexicon import IMPLIED, terms_of_text
from roadmend.sera.pattern import FailurePattern

# Quantities and the range [low, high] over which they are told apart.
RANGES: dict[str, tuple[float, float]] = {
    "speed_limit": (5.0, 40.0),  # [m/s]
    "lanes": (1.0, 4.0),
    "participants": (0.0, 30.0),
    "friction": (0.2, 1.0),
    "sensing_range": (30.0, 160.0),  # [m]
    "ego_speed": (0.0, 35.0),  # [m/s]
    "hazard_distance": (0.0, 40.0),  # [m] the nearest
    "difficulty": (0.0, 1.0),
}
_FAILED = frozenset(f"outcome:{name}" for name in get_args(OutcomeName)) - {f"outcome:{SUCCESS}"}


@dataclass(frozen=True, slots=True)
class Features:
    """Terms with their counts, none of 0, and the quantities that are known."""

    terms: Mapping[str, int] = field(default_factory=dict)
    quantities: Mapping[str, float] = field(default_factory=dict)


def features(item: Descriptor | FailurePattern) -> Features:
    """What an item is compared by."""
    return _of_descriptor(item) if isinstance(item, Descriptor) else _of_pattern(item)


def _of_descriptor(descriptor: Descriptor) -> Features:
    road = descriptor.road
    terms = Counter(
        [
            f"road:{road.kind}",
            f"weather:{descriptor.weather}",
            f"light:{descriptor.light}",
            f"density:{descriptor.density}",
        ]
    )
    for group, value in (
        ("family", descriptor.family),
        ("control", road.control),
        ("manoeuvre", descriptor.manoeuvre),
        ("lanes", road.lanes),
    ):
        if value is not None:
            terms[f"{group}:{value}"] = 1
    if road.crossings:
        terms["crossings:yes"] = 1
    for kind, count in descriptor.participants.items():
        terms[f"participant:{kind}"] = count
    for driver, count in descriptor.drivers.items():
        terms[f"driver:{driver}"] = count
    for hazard in descriptor.hazards:
        terms.update(_hazard_terms(hazard.kind, hazard.participant, hazard.side))
    for statistics in descriptor.outcomes:
        for outcome, count in statistics.outcomes.items():
            terms[f"outcome:{outcome}"] += count
    if descriptor.notes:
        terms.update(terms_of_text(descriptor.notes))
    quantities = {
        "speed_limit": road.speed_limit,
        "lanes": road.lanes,
        "participants": sum(descriptor.participants.values()),
        "friction": descriptor.friction,
        "sensing_range": descriptor.sensing_range,
        "ego_speed": descriptor.ego_speed,
        "hazard_distance": min(
            (each.distance for each in descriptor.hazards if each.distance is not None), default=None
        ),
        "difficulty": descriptor.difficulty,
    }
    return Features(dict(+terms), {name: float(value) for name, value in quantities.items() if value is not None})


def _of_pattern(pattern: FailurePattern) -> Features:
    where, who, why = pattern.where, pattern.who, pattern.why
    terms = set(terms_of_text(pattern.words))
    for group, value in (
        ("outcome", pattern.what),
        ("family", where.family),
        ("road", where.road),
        ("control", where.control),
        ("lanes", where.lanes),
        ("density", where.density),
        ("weather", where.weather),
        ("light", where.light),
        ("participant", who.participant),
        ("driver", who.driver),
        ("manoeuvre", why.manoeuvre),
    ):
        if value is not None:
            terms.add(f"{group}:{value}")
    if why.hazard is not None:
        terms.update(_hazard_terms(why.hazard, who.participant, who.side))
    terms.update(_together(terms))
    quantities = {
        "speed_limit": where.speed_limit,
        "lanes": where.lanes,
        "ego_speed": why.ego_speed,
        # Of what fails, scenarios that are known to fail are more like it than those that are known not to.
        "difficulty": 1.0 if terms & _FAILED else None,
    }
    return Features(
        dict.fromkeys(sorted(terms), 1),
        {name: float(value) for name, value in quantities.items() if value is not None},
    )


def _hazard_terms(kind: HazardKind, participant: ParticipantKind | None, side: Side | None) -> list[str]:
    terms = []
    # One who cuts in and brakes does both: found by either, best by both together.
    for hazard in (f"hazard:{kind}", *IMPLIED.get(f"hazard:{kind}", ())):
        terms.append(hazard)
        terms += [_joint(hazard, "participant", participant)] if participant is not None else []
        terms += [_joint(hazard, "side", side)] if side is not None else []
    return terms


def _joint(hazard: str, group: str, value: str) -> str:
    return f"hazard+{group}:{hazard.partition(':')[2]}+{value}"


def _together(terms: set[str]) -> list[str]:
    """The joint terms that words leave open, where they speak of one hazard and one participant or side."""
    hazards = {term for term in terms if term.startswith("hazard:")}
    leading = hazards - {implied for term in hazards for implied in IMPLIED.get(term, ())}
    if len(leading) != 1:
        return []
    joint = []
    for group in ("participant", "side"):
        values = [term.partition(":")[2] for term in terms if term.startswith(f"{group}:")]
        joint += [_joint(hazard, group, values[0]) for hazard in hazards if len(values) == 1]
    return joint
