"""Filters: what a scenario must be, as bits, so that a million of them are sifted in a millisecond."""

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from typing import get_args

import numpy as np
from numpy.typing import NDArray

from roadmend.core.errors import InputError
from roadmend.sera.descriptor import PARTICIPANTS, Descriptor, HazardKind, Light, OutcomeName, RoadKind
from roadmend.world.families import FAMILIES
from roadmend.world.scenario import Weather

Bits = NDArray[np.uint64]
NONE = "none"  # no family, no hazard, never run
_VALUES: dict[str, tuple[str, ...]] = {
    "family": (*FAMILIES, NONE),
    "road": get_args(RoadKind),
    "weather": get_args(Weather),
    "light": get_args(Light),
    "hazard": (*get_args(HazardKind), NONE),
    "participant": PARTICIPANTS,
    "outcome": (*get_args(OutcomeName), NONE),
}
_BITS = {
    pair: np.uint64(1 << place)
    for place, pair in enumerate((group, value) for group, values in _VALUES.items() for value in values)
}


@dataclass(frozen=True, slots=True)
class Filters:
    """Of each group one of the values must hold; an empty group lets everything through.

    ``outcome`` holds for a scenario if any run of it ended so. ``none`` stands for no family, no hazard, never run.
    """

    family: tuple[str, ...] = ()
    road: tuple[str, ...] = ()
    weather: tuple[str, ...] = ()
    light: tuple[str, ...] = ()
    hazard: tuple[str, ...] = ()
    participant: tuple[str, ...] = ()
    outcome: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for group, values in asdict(self).items():
            for value in values:
                if value not in _VALUES[group]:
                    raise InputError(group, f"there is no {value!r}", f"choose from {', '.join(_VALUES[group])}")

    def matches(self, bits: Bits) -> NDArray[np.bool_] | None:
        """Which of the scenarios pass, by their bits (shape: n); None where all do."""
        passed: NDArray[np.bool_] | None = None
        for group, values in asdict(self).items():
            if values:
                held = (bits & _mask(group, values)) != 0
                passed = held if passed is None else passed & held
        return passed


def facet_bits(descriptor: Descriptor) -> int:
    """What filters look at, one bit a fact."""
    ended = {name for each in descriptor.outcomes for name, count in each.outcomes.items() if count}
    facts: Mapping[str, Iterable[str]] = {
        "family": (descriptor.family or NONE,),
        "road": (descriptor.road.kind,),
        "weather": (descriptor.weather,),
        "light": (descriptor.light,),
        "hazard": {each.kind for each in descriptor.hazards} or (NONE,),
        "participant": descriptor.participants,
        "outcome": ended or (NONE,),
    }
    return int(sum(_mask(group, values) for group, values in facts.items()))


def _mask(group: str, values: Iterable[str]) -> np.uint64:
    mask = np.uint64(0)
    for value in values:
        mask |= _BITS[group, value]
    return mask
