"""Claims weighed against each other: what a field's value is, how surely, and what speaks against it."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from roadmend.safe.claims import Claim

_AGAIN = 0.25  # how much a second claim of the same source for the same value adds, of its own weight
_HELD = (0.02, 0.985)  # no single claim is surer than that
_TOLD = 0.01  # probability of a second reading that is kept


@dataclass(frozen=True, slots=True)
class JudgedField:
    """What the solver makes of one field.

    Attributes:
        value: the best; None where no value stands out.
        confidence: its probability.
        claims: those for it, the strongest first.
        second: the next best value, and its probability; None where there is none.
        against: claims for other values.
    """

    value: Any
    confidence: float
    claims: tuple[Claim, ...] = ()
    second: tuple[Any, float] | None = None
    against: tuple[Claim, ...] = ()


NO_VALUE = JudgedField(None, 0.0)


def judge(claims: Sequence[Claim]) -> JudgedField:
    """Weigh the claims about one field that depends on no other; something that nobody has said may be true, too."""
    weights = evidence(claims)
    total = sum(math.exp(weight) for weight in weights.values()) + 1.0
    ranked = sorted(weights.items(), key=lambda each: -each[1])
    return with_claims([(value, math.exp(weight) / total) for value, weight in ranked], claims) if ranked else NO_VALUE


def with_claims(ranked: Sequence[tuple[Any, float]], claims: Sequence[Claim]) -> JudgedField:
    """The best of some values, given with their probabilities, and the claims for and against it."""
    value, confidence = ranked[0]
    mine = sorted((each for each in claims if each.value == value), key=lambda each: -each.confidence)
    against = tuple(each for each in claims if each.value != value)
    second = ranked[1] if len(ranked) > 1 and ranked[1][1] > _TOLD else None
    return JudgedField(value, confidence, tuple(mine), second, against)


def log_odds(confidence: float) -> float:
    """The weight of a claim [nats]."""
    held = min(max(confidence, _HELD[0]), _HELD[1])
    return math.log(held / (1 - held))


def evidence(claims: Sequence[Claim], among: int = 2) -> dict[Any, float]:
    """Weight of each value [nats]: the strongest claim of a source in full, its repetitions a little.

    Args:
        claims: about one field.
        among: how many values the field has; a claim for one is against each of the others a share of its doubt.
    """
    by_source: dict[tuple[Any, str], list[float]] = {}
    for each in claims:
        by_source.setdefault((each.value, each.source), []).append(log_odds(each.confidence))
    found: dict[Any, float] = {}
    for (value, _), weights in by_source.items():
        first, *rest = sorted(weights, reverse=True)
        again = min(1.0, sum(_AGAIN * max(0.0, each) for each in rest[:3]))
        found[value] = found.get(value, 0.0) + first + again
    return {value: weight + math.log(among - 1) * min(1.0, max(0.0, weight)) for value, weight in found.items()}


def add(sums: dict[Any, float], value: Any, weight: float) -> None:
    """Add a probability to a value's, both as logarithms."""
    old = sums.get(value, -math.inf)
    top = max(old, weight)
    sums[value] = top + math.log(math.exp(old - top) + math.exp(weight - top))


def shares(sums: Mapping[Any, float]) -> list[tuple[Any, float]]:
    """Values with their probabilities, the best first, from unscaled logarithms."""
    top = max(sums.values())
    total = sum(math.exp(each - top) for each in sums.values())
    found = [(value, math.exp(weight - top) / total) for value, weight in sums.items()]
    return sorted(found, key=lambda each: (-each[1], str(each[0])))
