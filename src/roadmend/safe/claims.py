"""What a source says about a crash, one statement at a time: what the consistency solver decides between.

The summary and the sketch speak the same language. A :class:`Claim` fills one field, a :class:`DirectionClaim` ties the
ways of two vehicles together without naming either, a :class:`ContactClaim` says who touched whom and with what.
Vehicles are called by their place in the cast, from 0, as in the JSON form: ``vehicles[0]`` is vehicle 1.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from roadmend.safe.dsl import DslModel, Side


class ClaimSource(StrEnum):
    """Who says it."""

    SUMMARY = "summary"
    SKETCH = "sketch"
    TRAINED = "trained reader"


@dataclass(frozen=True, slots=True, order=True)
class Span:
    """A piece of the summary: the characters from ``start`` up to, not including, ``end``."""

    start: int
    end: int

    def __post_init__(self) -> None:
        if not 0 <= self.start <= self.end:
            raise ValueError(f"a span from {self.start} to {self.end} is none")


@dataclass(frozen=True, slots=True, order=True)
class Box:
    """A piece of the sketch [pixels], from its upper left corner."""

    left: float
    top: float
    right: float
    bottom: float

    def __post_init__(self) -> None:
        if not (self.left <= self.right and self.top <= self.bottom):
            raise ValueError("a box's right and bottom lie before its left and top")


Place = Span | Box


@dataclass(frozen=True, slots=True)
class Claim:
    """One field has one value, as far as this source goes.

    Attributes:
        path: of the field in the JSON form: "road_type", "vehicles[0].initial_position", "env.weather".
        value: as the scenario language has it: a member of its enumeration, a number, True or False.
        confidence: that it is right, were it alone; above 0, at most 1.
        source: who says it.
        reason: by what rule, in words for a reader.
        where: what it was read from; None where it follows from no single place.
    """

    path: str
    value: Any
    confidence: float
    source: ClaimSource
    reason: str
    where: Place | None = None

    def __post_init__(self) -> None:
        _check_confidence(self.confidence)


class WayRelation(StrEnum):
    """How the ways of two vehicles lie to each other before either turns."""

    SAME = "same direction"
    OPPOSITE = "opposite directions"
    CROSSING = "crossing directions"
    FROM_LEFT = "the second comes from the left of the first"
    FROM_RIGHT = "the second comes from the right of the first"


@dataclass(frozen=True, slots=True)
class DirectionClaim:
    """Two vehicles' directions of travel lie to each other in a certain way.

    Attributes:
        first: place of the one in the cast, from 0.
        second: place of the other.
        relation: how.
        confidence, source, reason, where: as in :class:`Claim`.
    """

    first: int
    second: int
    relation: WayRelation
    confidence: float
    source: ClaimSource
    reason: str
    where: Place | None = None

    def __post_init__(self) -> None:
        _check_pair(self.first, self.second)
        _check_confidence(self.confidence)


@dataclass(frozen=True, slots=True)
class ContactClaim:
    """Two vehicles touched.

    Attributes:
        striking: place of the one that ran into the other, from 0.
        struck: place of the other.
        striking_side: what the first hit with; None where nothing is said.
        struck_side: where the second was hit; None where nothing is said.
        order: among the contacts of its source, from 0.
        confidence, source, reason, where: as in :class:`Claim`.
    """

    striking: int
    struck: int
    striking_side: Side | None
    struck_side: Side | None
    order: int
    confidence: float
    source: ClaimSource
    reason: str
    where: Place | None = None

    def __post_init__(self) -> None:
        _check_pair(self.striking, self.struck)
        _check_confidence(self.confidence)


AnyClaim = Claim | DirectionClaim | ContactClaim


@dataclass(frozen=True, slots=True)
class CastMember:
    """A vehicle of which the summary speaks.

    Attributes:
        number: by which the report calls it, from 1; vehicles without a number are counted in the order of appearance.
        names: what the summary calls it, in lower case ("vehicle 1", "honda civic", "pickup"), longest first.
        model: its body class, where known.
    """

    number: int
    names: tuple[str, ...]
    model: DslModel | None


Cast = Sequence[CastMember]


def _check_confidence(confidence: float) -> None:
    if not 0 < confidence <= 1:
        raise ValueError(f"a confidence of {confidence} does not lie above 0 and at most 1")


def _check_pair(first: int, second: int) -> None:
    if first == second or min(first, second) < 0:
        raise ValueError(f"{first} and {second} are no two places in the cast")
