"""Light and weather."""

import re
from collections.abc import Iterator, Sequence

from roadmend.safe.claims import Claim, Span
from roadmend.safe.dsl import Time, Weather
from roadmend.safe.reading.facts import Text, claim
from roadmend.safe.reading.lexicon import read_table
from roadmend.safe.reading.tokens import Item

_DAY = range(6, 20)  # hours
_EVENING = range(17, 21)  # light or dark, by the season
_CLOCK = re.compile(
    r"\b(?:(?P<h>[01]?\d|2[0-3])[:.](?P<m>[0-5]\d)|(?P<mil>(?:[01]\d|2[0-3])[0-5]\d)(?=\s*(?:hrs?|hours|h)\b)|(?P<hour>1[0-2]|[1-9]))\s*(?:(?P<half>[ap])\.?\s?m\b|(?P<oclock>o'?clock)|(?P<hrs>hrs?|hours)\b)?",
    re.IGNORECASE,
)
_SKY = frozenset(
    {
        "sky",
        "skies",
        "weather",
        "conditions",
        "day",
        "night",
        "atmospheric",
        "sunny",
        "dry",
        "morning",
        "afternoon",
        "evening",
        "it",
        "was",
        "clear",
        "daylight",
        "dark",
        "wx",
        "and",
        "with",
        "/",
    }
)


def read_surroundings(text: Text) -> Iterator[Claim]:
    """The claims of a text about light and weather."""
    yield from _clock(text.summary)
    tables = read_table("surroundings")
    not_weather, past = frozenset(tables["not_weather"]), tuple(tables["past"])
    for sentence in text.sentences:
        for place, item in enumerate(sentence.items):
            if item.is_a("time") and not _is_other_time(sentence.items, place):
                value, confidence = item.kinds["time"]
                yield claim("env.time", Time(value), confidence, f"the text says {item.low}", item.span)
            if item.is_a("weather"):
                low = _around(text.summary, sentence.span, item.span)
                is_past = any(word in low for word in past)
                yield from _weather(sentence.items, place, not_weather, is_past=is_past)


def _around(summary: str, sentence: Span, place: Span) -> str:
    """The part of a sentence around a word, up to the next comma or "but"."""
    before = re.split(r"[,;]|\bbut\b", summary[sentence.start : place.start].lower())[-1]
    return before + re.split(r"[,;]|\bbut\b", summary[place.start : sentence.end].lower())[0]


def _is_other_time(items: Sequence[Item], place: int) -> bool:
    """Whether a word for a time is of another time than the crash: "treated later that morning", "released the same day"."""
    item = items[place]
    low = {each.low for each in items[max(0, place - 4) : place]}
    after = items[place + 1].low if place + 1 < len(items) else ""
    if item.low == "day":
        return not (low & {"sunny", "bright", "clear", "rainy", "windy", "snowy", "cloudy", "foggy"})
    treated = any(
        each.verb is not None
        and each.verb.lemma in {"treat", "transport", "admit", "release", "interview", "arrest", "die"}
        for each in items[:place]
    )
    return (
        treated
        or (
            low
            & {
                "later",
                "next",
                "following",
                "until",
                "since",
                "by",
                "previous",
                "before",
                "worked",
                "every",
                "spokesman",
            }
            != set()
            and item.low != "daylight"
        )
        or (
            item.low == "dark"
            and after
            in {
                "blue",
                "green",
                "grey",
                "gray",
                "red",
                "color",
                "colour",
                "colored",
                "coloured",
                "signal",
                "suv",
                "car",
                "sedan",
            }
        )
    )


def _weather(items: Sequence[Item], place: int, not_weather: frozenset[str], *, is_past: bool) -> Iterator[Claim]:
    item = items[place]
    value = Weather(item.kinds["weather"][0])
    before, after = items[max(0, place - 3) : place], items[place + 1 : place + 2]
    denied = any(each.is_a("negation") or each.low in {"no", "without"} for each in before)
    if value is Weather.CLEAR and len(item.low.split()) == 1:
        around = {each.low for each in [*items[max(0, place - 6) : place], *items[place + 1 : place + 4]]}
        follows = after[0].low if after else ""
        led = items[place - 1].low if place else ""
        is_listed = led in {",", ":", "", "/", "-"} and follows in {",", "", "/", ";", "dry"}
        if is_listed:
            yield claim("env.weather", value, 0.75, f"the text says {item.low}", item.span)
            return
        if (
            (follows in not_weather and not around & {"weather", "sky", "skies"})
            or not around & _SKY
            or (
                led in {"to", "a", "of"}
                and not any(each.is_a("time") or each.low in {"day", "sky"} for each in items[place + 1 : place + 5])
            )
        ):
            return
        if any(
            each.is_a("road", "lane", "signal") or each.low in {"view", "traffic", "coast", "way"} for each in before
        ) and not around & {"weather", "sky", "skies"}:
            return
    elif (
        value is Weather.WINDY
        and item.low in {"wind", "winds"}
        and after
        and after[0].low in {"screen", "shield", "ing"}
    ):
        return
    elif (
        value is Weather.SNOWY
        and any(each.low in {"cleared", "packed", "covered", "ploughed", "plowed", "fresh"} for each in before)
    ) or (
        item.low == "snow"
        and after
        and after[0].low in {"covered", "packed", "tires", "tyres", "bank", "banks", "plow"}
    ):
        yield claim("env.weather", value, 0.45, f"the text says {item.low}", item.span)
        return
    if denied:
        if value not in {Weather.CLEAR, Weather.SUNNY}:
            yield claim("env.weather", Weather.CLEAR, 0.4, f"the text denies {item.low}", item.span)
        return
    confidence = {Weather.CLEAR: 0.75, Weather.CLOUDY: 0.85, Weather.WINDY: 0.85, Weather.SUNNY: 0.88}.get(value, 0.93)
    yield claim("env.weather", value, confidence * (0.5 if is_past else 1.0), f"the text says {item.low}", item.span)


def _clock(summary: str) -> Iterator[Claim]:
    for match in _CLOCK.finditer(summary):
        hour, sure = _hour(match, summary)
        if hour is None:
            continue
        value = Time.DAYTIME if hour in _DAY else Time.NIGHTTIME
        confidence = 0.6 if hour in _EVENING or hour == _DAY[0] else 0.9
        yield claim("env.time", value, min(confidence, sure), f"the clock says {match[0].strip()}", Span(*match.span()))


def _hour(match: re.Match[str], summary: str) -> tuple[int | None, float]:
    after, before = (
        summary[match.end() : match.end() + 30].lower(),
        summary[max(0, match.start() - 20) : match.start()].lower(),
    )
    if match["mil"]:
        return int(match["mil"][:2]), 0.9
    hour = int(match["h"] or match["hour"])
    half = (match["half"] or "").lower()
    at_night = re.match(r"[\s,]*(?:in the evening|at night|tonight|p\.?m)", after)
    in_day = re.match(r"[\s,]*(?:in the morning|in the afternoon)", after)
    told = re.search(
        r"(?:\bat|around|about|approximately|aprox|approx|past|after|before|@|by|near|shortly|till|until)\s*$", before
    )
    if half:
        return (hour % 12) + (12 if half == "p" else 0), 0.92
    if at_night:
        return (hour % 12) + (12 if hour > 4 else 0), 0.92
    if in_day:
        return (hour % 12) + (12 if "afternoon" in in_day[0] else 0), 0.92
    if match["h"] and (told or match["hrs"] or hour >= 13 or len(match["h"]) == 2):
        return hour, 0.8 if told or match["hrs"] or hour >= 13 else 0.6
    return None, 0.0
