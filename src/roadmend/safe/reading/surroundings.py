"""Light and weather."""

import re
from collections.abc import Iterator

from roadmend.safe.claims import Claim, Span
from roadmend.safe.dsl import Time, Weather
from roadmend.safe.reading.facts import Text, claim
from roadmend.safe.reading.lexicon import read_table, word_set
from roadmend.safe.reading.tokens import Words

_DAY = range(6, 20)  # hours
_EVENING = range(17, 21)  # light or dark, by the season
_AFTERNOON = 13
_PARTS = {"afternoon": Time.DAYTIME, "morning": Time.DAYTIME, "day": Time.DAYTIME, "night": Time.NIGHTTIME}
_SMALL = (1, 2, 3, 4)  # hours before light
_MORNING = 6
_CLOCK = re.compile(
    r"\b(?:(?P<h>[01]?\d|2[0-3])[:.h][0-5]\d(?!\d|\s*(?:m|met(?:er|re)s?|feet|foot|ft|km|miles?|mi|mph|seconds?|sec|s)\b|\s*%)|(?P<mil>(?:[01]\d|2[0-3])[0-5]\d)(?=\s*(?:hrs?|hours|h)\b)|"
    r"(?P<log>(?:(?<=time )|(?<=time: )|(?<=rcvd )|(?<=call )|(?<=arr )|(?<=at )|(?<=approx )|(?<=about )|(?<=around )|(?<=@ )|(?<=\()|(?<=dry )|(?<=clr )|(?<=wet )|(?<=clear )|(?<=day )|(?<=dark )|^|(?<=, )|(?<=\. )|(?<=\n)|"
    r"(?<=\d/\d )|(?<=\d/\d\d )|(?<=(?:mon|tue|wed|thu|fri|sat|sun|jan|feb|mar|apr|may|jun|jul|aug|sep|oct|nov|dec) ))"
    r"(?:[01]\d|2[0-3])[0-5]\d(?=[\s,.:]))|"
    r"(?P<bare>(?<=, )(?:0\d|1[0-8]|2[1-3])[0-5]\d(?=[.,]|$)|(?<![\w.,:/-])0\d[0-5]\d(?=\s))|"
    r"(?P<joined>(?:1[0-2]|[1-9])[0-5]\d)(?=\s*[ap]\.?m\b)|"
    r"(?P<late>1[3-9]|2[0-3])(?=\s*(?:o'?clock|h\b|uhr))|"
    r"(?P<hour>1[0-2]|[1-9]))\s*(?:(?P<half>[ap])\.?\s?m\b|o'?clock|(?P<hrs>hrs?|hours)\b)?",
    re.IGNORECASE | re.MULTILINE,
)
_HOURS = ("one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve")
_WORDED = re.compile(
    r"(?P<past>\b(?:a )?(?:quarter|half|five|ten|twenty|twenty[- ]five)(?: minutes)? (?:past|after|to|before|of|till) )?"
    rf"\b(?P<hour>{'|'.join(_HOURS)})\b(?P<then>[- ](?:fifteen|thirty|forty[- ]five|ten|twenty|forty|fifty))?"
    r"(?P<clock> o'?clock)?,?(?: or so)?(?: (?P<when>in the (?:morning|afternoon|evening)|at night|p\.?m\b|a\.?m\b|(?:on )?\w+ night|"
    r"that (?:night|evening|morning|afternoon)|last night|tonight))?",
    re.IGNORECASE,
)
_AT_NIGHT = re.compile(r"[\s,]*(?:in the evening|at night|tonight|p\.?m)")
_IN_DAY = re.compile(r"[\s,]*in the (?:morning?|(afternoon?))")
_EARLIER = re.compile(r"\b(?:evening|night|tonight)\b[^.!?]*$", re.IGNORECASE)
_TOLD = re.compile(r"(?:\bat|around|about|approximately|aprox|approx|past|after|before|@|by|near|till|until)\s*$")
_AFTERMATH = re.compile(
    r"\b(?:reopen|clean[- ]?up|cleaned|until|till|discharged|notified|interview|phoned|statement)", re.IGNORECASE
)
_GREY_SKY = re.compile(
    r"\b(?:sk(?:y|ies)|overhead|everything|outside|weather)\b[^.,;!?\n]{0,20}\bgr[ae]y\b|\bsky (?:was )?the colou?r of\b"
    r"|\bgr[ae]y (?:(?:and|all|from|one|up|dull|low|heavy|winter|solid) )*(?:sk(?:y|ies)|overhead|above|over\b|out\b|outside|end\b)",
    re.IGNORECASE,
)
_SURE = {Weather.CLEAR: 0.75, Weather.CLOUDY: 0.85, Weather.WINDY: 0.85, Weather.SUNNY: 0.88}
_NAMES = {"weather", "sky", "skies"}


def read_surroundings(text: Text) -> Iterator[Claim]:
    """The claims of a text about light and weather."""
    yield from _clock(text.summary)
    yield from _told_hours(text.summary)
    for match in _GREY_SKY.finditer(text.summary):
        yield claim("env.weather", Weather.OVERCAST, 0.8, "the sky is called grey", Span(*match.span()))
    past = read_table("surroundings")["past"]
    for sentence in text.sentences:
        for place, item in enumerate(sentence.items):
            if item.is_a("time", "weather") and _is_of_street(sentence.items, place):
                continue
            if item.is_a("time") and not _is_other_time(sentence.items, place):
                value, confidence = item.get("time")
                yield claim("env.time", Time(value), confidence, f"the text says {item.low}", item)
            if item.is_a("weather") and not item.is_a("time"):
                part = next((each for each in item.low.split() if each in _PARTS), None)
                if part is not None:
                    yield claim("env.time", _PARTS[part], 0.85, f"the text says {item.low}", item)
            if item.is_a("weather"):
                around = _around(text.summary, sentence.span, item.span)
                yield from _weather(sentence.items, place, is_past=any(word in around for word in past))


def _is_of_street(items: Words, place: int) -> bool:
    """Whether a word with a capital is a part of a name: "on Sunset Boulevard", "Misty Hill Road", "Mrs. Rain"."""
    item, before, after = items[place], items.at(place - 1), items.cut(place + 1, place + 3)
    led = before.is_a("preposition", "compass", "determiner", "number", "conjunction")
    led |= before.low.endswith(("/", " on", " at"))
    street = next((at for at, each in enumerate(after) if each.is_a("road", "lane")), None)
    named = led and street is not None and all(each.is_name for each in after.cut(0, street + 1))
    return item.text.istitle() and (named or before.low in word_set("titles"))


def _around(summary: str, sentence: Span, place: Span) -> str:
    """The part of a sentence around a word, up to the next comma or "but"."""
    before = re.split(r"[,;]|\bbut\b", summary[sentence.start : place.start].lower())[-1]
    return before + re.split(r"[,;]|\bbut\b", summary[place.start : sentence.end].lower())[0]


def _is_other_time(items: Words, place: int) -> bool:
    """Whether a word is of another time than the crash: "treated later that morning", "released the same day"."""
    item, before = items[place], items.cut(place - 4, place)
    if item.low in {"morning", "the morning"} and any(each.get("number") in _SMALL for each in before):
        return True  # "two in the morning"
    if item.low == "day" and (before.at(len(before) - 1).low in {",", "/", ":"} or len(items) == 1):
        return False
    if item.low == "day":
        return not before.says(word_set("bright_days"))
    treated = any(each.verb is not None and each.verb.lemma in word_set("treated") for each in items[:place])
    if item.low == "night shift" and before.says(word_set("over_with")):
        return True
    later = before.says(word_set("other_time")) and item.low != "daylight"
    return treated or later or (item.low == "dark" and items.at(place + 1).low in word_set("dark_colours"))


def _weather(items: Words, place: int, *, is_past: bool) -> Iterator[Claim]:
    item, before = items[place], items.cut(place - 3, place)
    value = Weather(item.get("weather")[0])
    if value is Weather.CLEAR and item.low in word_set("may_be_clear") and not _is_sky(items, place):
        return
    after = items.at(place + 1)
    if item.low in {"cloud", "sun"} and (after.low in word_set("no_weather_after") or after.is_a("number")):
        return  # "the sun set"; "Sun 0140" is a day of the week
    lies = before.says(word_set("lying_snow")) or items.at(place + 1).low in word_set("lying_snow")
    if value is Weather.SNOWY and lies:
        yield claim("env.weather", value, 0.45, f"the text says {item.low}", item)
    elif not before.has("negation") and not before.says({"without"}) and not _is_denied(items, place):
        if value is Weather.SUNNY:
            yield claim("env.time", Time.DAYTIME, 0.9, f"the text says {item.low}", item)
        sure = _SURE.get(value, 0.93) * (0.5 if is_past else 1.0)
        yield claim("env.weather", value, sure, f"the text says {item.low}", item)
    elif value not in {Weather.CLEAR, Weather.SUNNY}:
        yield claim("env.weather", Weather.CLEAR, 0.4, f"the text denies {item.low}", item)


def _is_denied(items: Words, place: int) -> bool:
    """Whether the weather is said not to have come: "rain did not fall"."""
    after = items.cut(place + 1, place + 3)
    return after.at(0).is_a("negation") or (after.at(0).is_a("auxiliary") and after.at(1).is_a("negation"))


def _is_sky(items: Words, place: int) -> bool:
    """Whether it is the sky that is clear or fine, not a view or a road."""
    led, follows = items.at(place - 1).low, items.at(place + 1).low
    if items.at(place + 1).is_a("time") or items.at(place - 1).is_a("time"):
        return True
    if led in {",", ":", "", "/", "-"} and follows in {",", "", "/", ";", "dry"}:
        return True
    around = {each.low for each in (*items.cut(place - 6, place), *items.cut(place + 1, place + 4))}
    named = bool(around & _NAMES)
    ahead, before = items.cut(place + 1, place + 5), items.cut(place - 3, place)
    if led in {"to", "a", "of"} and not ahead.has("time") and not ahead.says({"day", "sky"}):
        return False
    other = before.has("road", "lane", "signal") or before.says({"view", "traffic", "coast", "way"})
    other |= items.cut(place - 2, place - 1).has("junction")  # "the intersection was clear"
    return bool(around & word_set("sky")) and (named or (not other and follows not in word_set("not_weather")))


def _clock(summary: str) -> Iterator[Claim]:
    for match in _CLOCK.finditer(summary):
        hour, sure = _hour(match, summary)
        if hour is not None:
            value = Time.DAYTIME if hour in _DAY else Time.NIGHTTIME
            sure = min(sure, 0.6 if hour in _EVENING or hour == _DAY[0] else 0.98)
            before = re.split(r"[.!?\n]\s", summary[max(0, match.start() - 80) : match.start()])[-1]
            sure *= 0.5 if _AFTERMATH.search(before) else 1.0  # "the road reopened at 9 p.m."
            yield claim("env.time", value, sure, f"the clock says {match[0].strip()}", Span(*match.span()))


def _told_hours(summary: str) -> Iterator[Claim]:
    """Hours in words: "a quarter to nine in the evening", "eleven-fifteen p.m."."""
    for match in _WORDED.finditer(summary):
        minutes, when = match["past"] or match["then"] or match["clock"], (match["when"] or "").lower()
        hour = _HOURS.index(match["hour"].lower()) + 1
        if not (minutes or when):
            continue
        late = any(word in when for word in ("night", "evening", "afternoon", "p"))
        early = any(word in when for word in ("morning", "a.m", "am"))
        if "night" in when and hour < _MORNING:
            late = False
        if not (late or early):
            late = hour < _MORNING or _EARLIER.search(summary[max(0, match.start() - 60) : match.start()]) is not None
        value = Time.DAYTIME if hour % 12 + 12 * late in _DAY else Time.NIGHTTIME
        sure = 0.9 if when else 0.6
        yield claim("env.time", value, sure, f"the clock says {match[0].strip()}", Span(*match.span()))


def _hour(match: re.Match[str], summary: str) -> tuple[int | None, float]:
    """The hour of a time of day from 0 to 23, and how surely it is one."""
    after = summary[match.end() : match.end() + 30].lower()
    told = _TOLD.search(summary[max(0, match.start() - 20) : match.start()].lower()) or match["hrs"]
    log = match["log"] if match["log"] and not match["log"].startswith(("19", "20")) else None
    figures = match["mil"] or match["bare"] or match["late"] or log
    if figures:
        return int(figures[:2]), 0.9 if match["mil"] else 0.75
    if match["log"]:
        return None, 0.0
    hour, half, in_day = (
        int(match["h"] or (match["joined"] or "")[:-2] or match["hour"]),
        (match["half"] or "").lower(),
        _IN_DAY.match(after),
    )
    at_night = _AT_NIGHT.match(after) is not None and hour > 4
    if half or at_night or in_day or _AT_NIGHT.match(after):
        late = half == "p" or (not half and (at_night or (in_day is not None and in_day[1])))
        return hour % 12 + (12 if late else 0), 0.98
    if match["hour"] and after.startswith("ish") and hour < _MORNING:
        return hour + 12, 0.6
    if match["h"] and (told or len(match["h"]) == 2):
        if 0 < hour < _MORNING and len(match["h"]) == 1:
            return hour + 12, 0.6  # nobody says whether it was night: few drive then
        return hour, 0.8 if told or hour >= _AFTERNOON else 0.6
    return None, 0.0
