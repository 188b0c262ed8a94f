"""The text of a crash report cut into phrases, each with the fields that were read from it."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from roadmend.core.appearance import VEHICLE_COLOURS

_VEHICLE = re.compile(r"vehicles\[(\d+)\]")
_COLOURS = {"road": "#5b6b00", "environment": "#6a5acd", "contact": "#b3361b"}


@dataclass(frozen=True, slots=True)
class Phrase:
    """A piece of the text.

    Attributes:
        text: of it.
        fields: that were read from it, the one that it is narrowest for first; none for what filled nothing.
    """

    text: str
    fields: tuple[str, ...] = ()

    @property
    def colour(self) -> str:
        """Of its first field."""
        return colour_of(self.fields[0]) if self.fields else ""


def family_of(field: str) -> str:
    """What a field is about: "road", "environment", "contact", or "vehicle 1" and so on."""
    vehicle = _VEHICLE.match(field)
    if vehicle is not None:
        return f"vehicle {int(vehicle[1]) + 1}"
    if field.startswith("env."):
        return "environment"
    return "contact" if field.startswith(("collisions", "impacts")) else "road"


def colour_of(field: str) -> str:
    """Of the family of a field; vehicles have the colours that they have on the sketch."""
    family = family_of(field)
    if family in _COLOURS:
        return _COLOURS[family]
    number = int(family.removeprefix("vehicle "))
    return VEHICLE_COLOURS[(number - 1) % len(VEHICLE_COLOURS)]


def phrases_of(summary: str, fields: Mapping[str, Mapping[str, Any]]) -> tuple[Phrase, ...]:
    """The whole text, cut where a span of a field begins or ends; spans outside the text are left out."""
    spans = sorted(_spans(summary, fields), key=lambda span: span[1] - span[0])
    cuts = sorted({0, len(summary), *(edge for begin, end, _ in spans for edge in (begin, end))})
    return tuple(_piece(summary, begin, end, spans) for begin, end in pairwise(cuts))


def _piece(summary: str, begin: int, end: int, spans: Sequence[tuple[int, int, str]]) -> Phrase:
    fields = tuple(field for first, last, field in spans if first <= begin and end <= last)
    return Phrase(summary[begin:end], fields)


def _spans(summary: str, fields: Mapping[str, Mapping[str, Any]]) -> Iterable[tuple[int, int, str]]:
    for field, evidence in fields.items():
        span = evidence.get("span")
        if span is not None and 0 <= span[0] < span[1] <= len(summary):
            yield int(span[0]), int(span[1]), field
