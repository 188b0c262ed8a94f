"""The speed limits that are posted on a sketch, and whom each is for."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum

from roadmend.safe.claims import Box
from roadmend.safe.dsl import KM_PER_MILE
from roadmend.safe.sketch.words import SketchWord, box_of, in_lines

_LOWEST, _HIGHEST = 5, 85  # [mph] posted anywhere in the United States
_STEP = 5  # [mph] limits are posted in
_ROUNDED = 2.6  # [mph] a limit in km/h and its miles differ by rounding

_SAYS_LIMIT = re.compile(r"(?:posted\W*)?speed\W*li[mn]i?t|speed\W*zone|\bposted\b|\blimit\b|\bpsl\b", re.IGNORECASE)
_OTHER_SPEED = re.compile(r"advis|travel\w*\s*speed|impact\s*speed|speed\s*at|est\w*\s*speed|delta", re.IGNORECASE)
_MPH = re.compile(r"(?<![\d.])(\d{1,3})\s*(?:m\s*\.?\s*p\s*\.?\s*h\b|miles?\s*(?:per|an|/)\s*h)", re.IGNORECASE)
_KMH = re.compile(r"(?<![\d.])(\d{2,3})\s*k\s*(?:m\s*)?\.?\s*(?:/|p)?\s*\.?\s*h\b", re.IGNORECASE)
_BARE = re.compile(r"(?<![\d.#/-])(\d{2})(?![\d.%/-])")
_MISREAD = str.maketrans({"O": "0", "o": "0", "l": "1", "I": "1", "S": "5"})
_DIGITS_MISREAD = re.compile(r"\b(?=[\dOoIlS]{2,3}\s*(?:mph|k))(?=\S*\d)[\dOoIlS]{2,3}(?=\s*(?:mph|k))")
_LABEL = 24  # [characters] a longer text says more than a limit
_TRUST_UNLABELLED = 0.7


class LimitScope(StrEnum):
    """Whom a limit is for."""

    ALL = "all"
    CARS = "cars"
    TRUCKS = "trucks"
    NORTH_SOUTH = "north and south"
    EAST_WEST = "east and west"
    RAMP = "ramp"
    VEHICLE = "one vehicle"


_SCOPES = (
    (LimitScope.TRUCKS, re.compile(r"\btrucks?\b|\bcommercial\b|\bsemis?\b|tractor", re.IGNORECASE)),
    (LimitScope.CARS, re.compile(r"\bcars?\b|passenger", re.IGNORECASE)),
    (LimitScope.RAMP, re.compile(r"\bramp\b|\bexit\b", re.IGNORECASE)),
    (
        LimitScope.NORTH_SOUTH,
        re.compile(r"\b(?:n\s*[/&]\s*s|n/?b|s/?b|(?:north|south)\w*)\b", re.IGNORECASE),
    ),
    (LimitScope.EAST_WEST, re.compile(r"\b(?:e\s*[/&]\s*w|e/?b|w/?b|(?:east|west)\w*)\b", re.IGNORECASE)),
)
_VEHICLE = re.compile(r"\bv(?:ehicle)?\s*#?\s*(\d)\b", re.IGNORECASE)


@dataclass(frozen=True, slots=True)
class SketchLimit:
    """A speed limit on the sketch.

    Attributes:
        mph: the limit.
        scope: whom it is for.
        vehicle: number of the vehicle where it is for one.
        box: where it is written [pixels].
        text: how.
        confidence: that it is posted, from 0 to 1.
    """

    mph: int
    scope: LimitScope
    box: Box
    text: str
    confidence: float
    vehicle: int | None = None


def posted_limits(words: Sequence[SketchWord]) -> tuple[SketchLimit, ...]:
    """All limits that the words post, each once."""
    limits: list[SketchLimit] = []
    lines = in_lines(words)
    for index, line in enumerate(lines):
        for piece in _pieces(line, lines[index + 1 :]):
            text = _mended(" ".join(word.text for word in piece))
            if not _OTHER_SPEED.search(text):
                found = _limits_in(text, box_of(piece), min(word.confidence for word in piece))
                limits.extend(found)
                if found:
                    break
    if not limits:
        limits.extend(_unlabelled(words))
    kept: dict[tuple[int, LimitScope, int | None], SketchLimit] = {}
    for limit in limits:
        key = (limit.mph, limit.scope, limit.vehicle)
        if key not in kept or kept[key].confidence < limit.confidence:
            kept[key] = limit
    return tuple(kept.values())


def _pieces(line: list[SketchWord], below: Sequence[list[SketchWord]]) -> Iterator[list[SketchWord]]:
    """Where a line may post a limit, narrowest first: a phrase, what follows it in its row, what stands under it."""
    for place, word in enumerate(line):
        if _SAYS_LIMIT.search(word.text):
            yield [word]
            yield line[place : place + 2]
            yield line[place:]
            under = _below([word], below)
            if under:
                yield [word, *under]


def _mended(text: str) -> str:
    return _DIGITS_MISREAD.sub(lambda match: match[0].translate(_MISREAD), text)


def _limits_in(text: str, box: Box, seen: float) -> list[SketchLimit]:
    """A line may post several: "70 mph for cars, 55 mph for trucks"; km/h beside mph is the same limit again."""
    miles = [(match.start(), match.end(), int(match[1])) for match in _MPH.finditer(text)]
    metric = [int(match[1]) for match in _KMH.finditer(text)]
    if not miles and metric:
        values = {_in_miles(kilometres) for kilometres in metric}
        if len(values) != 1:
            return []
        return _one(values.pop(), text, text, box, 0.9 * seen)
    if not miles:
        said = _SAYS_LIMIT.search(text)
        bare = _BARE.findall(text[said.start() :]) if said is not None else []
        return _one(int(bare[0]), text, text, box, 0.85 * seen) if len(bare) == 1 else []
    agreed = len(metric) == len(miles) and all(
        any(abs(value - kilometres / KM_PER_MILE) < _ROUNDED for kilometres in metric) for _, _, value in miles
    )
    limits = []
    for index, (begin, _, value) in enumerate(miles):
        last = index + 1 == len(miles)
        # Whom it is for stands behind a limit up to the next, or in front of it.
        piece = text[begin : None if last else miles[index + 1][0]]
        if len(miles) == 1 or (_scope(piece)[0] is LimitScope.ALL):
            piece = text[0 if index == 0 else miles[index - 1][1] : None if last else miles[index + 1][0]]
        limits.extend(_one(value, piece, text, box, (0.98 if agreed else 0.95) * seen))
    return limits


def _in_miles(kilometres: int) -> int:
    return _STEP * round(kilometres / KM_PER_MILE / _STEP)


def _one(value: int, piece: str, text: str, box: Box, confidence: float) -> list[SketchLimit]:
    if not _LOWEST <= value <= _HIGHEST or value % _STEP:
        return []
    scope, vehicle = _scope(piece)
    return [SketchLimit(value, scope, box, text, min(1.0, confidence), vehicle)]


def _scope(text: str) -> tuple[LimitScope, int | None]:
    numbers = {int(match[1]) for match in _VEHICLE.finditer(text)}
    if len(numbers) == 1:
        return LimitScope.VEHICLE, numbers.pop()
    found = [scope for scope, pattern in _SCOPES if pattern.search(text)]
    return (found[0] if len(found) == 1 else LimitScope.ALL), None


def _below(line: Sequence[SketchWord], others: Sequence[list[SketchWord]]) -> list[SketchWord]:
    """The line that stands right under another: a sign has its number below its words."""
    above = box_of(line)
    height = above.bottom - above.top
    for other in others:
        box = box_of(other)
        overlap = min(above.right, box.right) - max(above.left, box.left)
        if -0.5 * height < box.top - above.bottom < 1.2 * height and overlap > 0.3 * min(
            above.right - above.left, box.right - box.left
        ):
            return list(other)
    return []


def _unlabelled(words: Sequence[SketchWord]) -> list[SketchLimit]:
    """'35 MPH' alone: nobody says that it is a limit, so it is one only where there is no other speed."""
    found: list[SketchLimit] = []
    for word in words:
        text = _mended(word.text)
        if _MPH.search(text) and len(text) < _LABEL and not _OTHER_SPEED.search(text):
            found.extend(_limits_in(text, word.box, _TRUST_UNLABELLED * word.confidence))
    return found if len({limit.mph for limit in found}) == 1 else []
