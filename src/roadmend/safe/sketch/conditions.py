"""Light and weather, where a sketch's legend names them: "Dry, daylight, clear", "Time: 0330 hours (dark)"."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from roadmend.safe.claims import Box
from roadmend.safe.dsl import Time, Weather
from roadmend.safe.sketch.words import SketchWord, box_of, in_lines

_LABELLED = re.compile(r"\b(?:weather|time|light(?:ing)?|conditions?)\s*[:=]", re.IGNORECASE)
_WORDS = re.compile(r"[a-z]+", re.IGNORECASE)
_HOURS = re.compile(r"(?<!\d)([01]\d|2[0-3]):?([0-5]\d)\s*(?:hours|hrs|h\b)", re.IGNORECASE)
_TIMES = {
    **dict.fromkeys(("daylight", "daytime", "dawn", "dusk"), Time.DAYTIME),
    **dict.fromkeys(("dark", "night", "nighttime"), Time.NIGHTTIME),
}
_WEATHERS = {
    **dict.fromkeys(("rain", "raining", "rainy"), Weather.RAINY),
    **dict.fromkeys(("snow", "snowing", "snowy"), Weather.SNOWY),
    **dict.fromkeys(("fog", "foggy"), Weather.FOGGY),
    "clear": Weather.CLEAR,
    "sunny": Weather.SUNNY,
    "cloudy": Weather.CLOUDY,
    "overcast": Weather.OVERCAST,
    "windy": Weather.WINDY,
}
_SURFACES = frozenset({"dry", "wet", "icy", "asphalt", "bituminous", "concrete"})
_DAY, _NIGHT = range(8, 17), frozenset({21, 22, 23, 0, 1, 2, 3, 4})  # [h] in every season
_SAID, _BY_CLOCK = 0.9, 0.85


@dataclass(frozen=True, slots=True)
class SketchCondition:
    """Light or weather, as a sketch names it.

    Attributes:
        value: which.
        box: where it is written [pixels].
        text: how.
        confidence: from 0 to 1.
    """

    value: Time | Weather
    box: Box
    text: str
    confidence: float


def conditions(words: Sequence[SketchWord]) -> tuple[SketchCondition, ...]:
    """At most one light and one weather; none where the words contradict each other."""
    found = [condition for line in in_lines(words) for condition in _in_line(line)]
    times = [condition for condition in found if isinstance(condition.value, Time)]
    weathers = [condition for condition in found if isinstance(condition.value, Weather)]
    return tuple(
        max(same, key=lambda condition: condition.confidence)
        for same in (times, weathers)
        if len({condition.value for condition in same}) == 1
    )


def _in_line(line: Sequence[SketchWord]) -> Iterator[SketchCondition]:
    text = " ".join(word.text for word in line)
    tokens = [token.lower() for token in _WORDS.findall(text)]
    named = [token for token in tokens if token in _TIMES or token in _WEATHERS or token in _SURFACES]
    # One such word alone may be anything ("clear zone", "rain gutter"); a legend lists several, or labels them.
    if not _LABELLED.search(text) and len(set(named)) < 2:
        return
    seen, box = min(word.confidence for word in line), box_of(line)
    for token in named:
        value = _TIMES.get(token) or _WEATHERS.get(token)
        if value is not None:
            yield SketchCondition(value, box, text, _SAID * seen)
    clock = _HOURS.search(text)
    if clock is not None:
        hour = int(clock[1])
        if hour in _DAY or hour in _NIGHT:
            yield SketchCondition(Time.DAYTIME if hour in _DAY else Time.NIGHTTIME, box, text, _BY_CLOCK * seen)
