"""Light and weather."""

import re
from collections.abc import Sequence

from roadmend.safe.dsl import Time, Weather
from roadmend.safe.reading.text import Finding, Sentence, nothing

# Light is the surest sign, then the time of day, then words that may mean either; the first in the report counts.
_LIGHT = (
    (
        Time.NIGHTTIME,
        0.95,
        (
            r"dark(?:ness)?\b(?! (?:blue|green|red|grey|gray|brown|colou?red|tinted|clothing|clothes|suv|sedan|"
            r"spot|substance|smudge|pickup|van|car))|unlit\b|"
            r"street ?(?:lights?|lamps?) (?:were |was )?(?:on|present|lit|illuminated)|no daylight|after sunset|"
            r"moonlight|no street ?lights|not lighted|pitch black|before sunrise|after sundown"
        ),
    ),
    (
        Time.DAYTIME,
        0.95,
        (
            r"daylight|day ?time\b(?! running)|broad day|dawn|dusk|sunrise|sunset|twilight|full light|sunlight|"
            r"bright(?:ly)? sun\w*|sunny|in the light of day|light conditions were day|light out(?:side)?"
        ),
    ),
)
_PREDAWN = re.compile(r"\bpre-?\s?dawn\b|\bbefore dawn\b|\blight of dawn\b")
_HOURS = (
    (
        Time.NIGHTTIME,
        0.85,
        (r"night ?time|(?:over|mid)night|nights?\b(?!club)|late evening|post-?midnight|small hours|wee hours"),
    ),
    (
        Time.DAYTIME,
        0.85,
        (
            r"(?:mid|late|early)?[- ]?morning|noon|mid-?day|(?:early|mid|late)?[- ]?afternoon|rush hour|"
            r"lunch ?time|during the day\b|day hours|(?:sunny|cloudy|clear|rainy|overcast|bright|gr[ae]y|snowy|"
            r"foggy) (?:\w+ )?day\b"
        ),
    ),
    (Time.NIGHTTIME, 0.5, r"evening"),
)
_CLOCK = re.compile(
    r"\b(?:(\d{1,2})(?::\d\d)?\s*(a\.?m|p\.?m)\b|([01]\d|2[0-3]):?[0-5]\d\s*(?:hours|hrs)\b|"
    r"(?:at|about|around|approximately|near|was)\s+(\d{1,2}):[0-5]\d\b(?!\s*[ap]\.?m))"
)
_LATER = re.compile(
    r"\b(?:later (?:that|the) (?:day|morning|night|evening)|next (?:day|morning)|"
    r"the day (?:after|following|before)|previous (?:day|night)|the night before|hours (?:after|later)|hospital|"
    r"trauma|transported|treated|admitted|slept|sleep|worked|shift|headlights?|airbag|passerby|police report|"
    r"scene images)\b"
)

_NOT = r"(?<!no )(?<!not )(?<!without )(?<!stopped )(?<!any )(?<!earlier )"
_SKY = (
    (
        Weather.SNOWY,
        0.95,
        (
            rf"{_NOT}(?:snow(?:ing|fall|y|storm)|snow[ -]storm|blizzard|sleet(?:ing)?|snow flurries|flurries|hail(?:ing|storm)?|"
            r"snow (?:was|is) falling|falling snow|(?:light|heavy|blowing) snow)"
        ),
    ),
    (
        Weather.RAINY,
        0.95,
        (
            rf"{_NOT}(?:rain(?:ing|y|storm|fall|s)?|drizzl(?:e|ing|y)|showers?|downpour|thunderstorms?|"
            r"precipitation|rained|misting|freezing rain)(?! (?:earlier|gutter|had|before|"
            r"the (?:day|night) before))"
        ),
    ),
    (
        Weather.FOGGY,
        0.95,
        rf"{_NOT}(?:fog(?:gy)?\b(?! (?:lights?|lamps?|line))|mist\b|misty|hazy|haze|smog(?:gy)?|smoky)",
    ),
    (
        Weather.WINDY,
        0.9,
        (
            rf"{_NOT}(?:(?:strong|high|heavy|gusty|gusting|severe) (?:cross)?winds?|crosswinds?|gust[sy]?|"
            r"(?:weather|it|conditions?|day) (?:was|were) (?:\w+ and )?windy|windy (?:conditions|weather|day)|"
            r"(?:^|[,;] |and )windy[.;]?$)"
        ),
    ),
    (Weather.OVERCAST, 0.95, rf"{_NOT}overcast"),
    (Weather.CLOUDY, 0.95, rf"{_NOT}(?:clouds?|cloudy|grey sk(?:y|ies)|gray sk(?:y|ies))\b"),
    (
        None,
        0.95,
        (
            r"(?:sky|skies|weather(?: conditions?)?|atmospher\w+(?: conditions?)?|conditions?|day|night|evening|"
            r"morning|afternoon|visibility)\s+(?:was|were|is|being|had been|remained)\s+(?:reported (?:as|to be) |"
            r"described as |also |both )?(?:dry and |warm and |cool and |cold and |dark and |mostly |"
            r"generally )?(?:clear|sunny|fair|fine|good)\b"
        ),
    ),
    (
        None,
        0.95,
        (
            r"(?:clear|fair|sunny|cloudless|blue|good|fine),? (?:and (?:dry|sunny|bright|warm|cold|"
            r"cool) )?(?:sk(?:y|ies)|weather|conditions?|day(?:light|time)?|night|evening|morning|afternoon|"
            r"atmospher\w+)"
        ),
    ),
    (
        None,
        0.9,
        (
            r"(?:it was|was|were|weather:?|conditions:?) (?:(?:dark|daylight|day ?time|light|dry|"
            r"dusk|dawn|night ?time|(?:early |late |mid-?)?(?:morning|afternoon|evening|night)),? )?(?:and )?(?:clear|sunny)(?= and|,|\.|;| with| at| on|$)"
        ),
    ),
    (
        None,
        0.9,
        (
            r"no adverse (?:weather|atmospher\w+)|no (?:weather|atmospheric)[- ]related|"
            r"(?:weather|atmospheric) (?:conditions )?(?:was|were) (?:not (?:a|an) factor|normal)|under clear|"
            r"in clear\b|bright sun\w*|sunshine|clear and dry|clear, dry|dry and clear"
        ),
    ),
)
_COVERED = re.compile(r"\bsnow[- ]?(?:covered|packed)\b|\bcovered (?:with|in|by) snow\b")
_COMPILED_SKY = tuple((weather, confidence, re.compile(rf"\b(?:{words})")) for weather, confidence, words in _SKY)
_COMPILED_LIGHT, _COMPILED_HOURS = (
    tuple((time, confidence, re.compile(rf"(?<![\w-])(?:{words})")) for time, confidence, words in table)
    for table in (_LIGHT, _HOURS)
)
_OTHER_SENSE = re.compile(
    r"\bwindy (?:road|two|2|country|rural|roadway|section)|\bcleared?\b(?= (?:the|of|to|a|an|from|traffic|view))|"
    r"\bto (?:completely |fully )?clear\b|\brain[- ](?:gutter|x|sensor)|"
    r"\b(?:due to|because of|from) (?:the )?(?:earlier|previous) (?:rain|snow)\w*|"
    r"\b(?:snow|rain) (?:had|that) [^,.;]*|\bsnow ?(?:plow|bank|mobile|tires?|drift)s?\b|"
    r"\b(?:it|snow|rain) had (?:been )?(?:snow|rain)\w* (?:earlier|before|the)[^,.;]*"
)


def read_time(sentences: Sequence[Sentence]) -> tuple[Finding[Time], bool]:
    """Day or night, and whether the sun is up (not at dawn or dusk)."""
    for table in (_COMPILED_LIGHT, _COMPILED_HOURS):
        for sentence in sentences:
            if _LATER.search(sentence.plain):
                continue
            plain = sentence.plain
            if _PREDAWN.search(plain):
                return Finding(Time.NIGHTTIME, 0.9, sentence.text, "it is before dawn"), False
            if (by_clock := _by_clock(plain)) is not None and not any(p.search(plain) for _, _, p in _COMPILED_LIGHT):
                return Finding(by_clock, 0.85, sentence.text, "the time by the clock"), by_clock is Time.DAYTIME
            for time, confidence, words in table:
                match = words.search(plain)
                if match:
                    up = time is Time.DAYTIME and not re.search(r"\b(?:dawn|dusk|twilight)\b", plain)
                    return Finding(time, confidence, sentence.text, f"the words '{match[0].strip()}'"), up
    return nothing("neither light nor time of day is mentioned"), True


def _by_clock(plain: str) -> Time | None:
    match = _CLOCK.search(plain)
    if match is None:
        return None
    hour_12, half, hour_24, hour_plain = match.groups()
    hour = int(hour_12 or hour_24 or hour_plain)
    if half:
        hour = hour % 12 + (12 if half.startswith("p") else 0)
    elif hour_plain and hour < 13:
        return None  # of the morning or of the evening: not said
    return Time.DAYTIME if 6 <= hour < 19 else Time.NIGHTTIME


def read_weather(sentences: Sequence[Sentence], time: Time | None, *, sun_is_up: bool) -> Finding[Weather]:
    """The weather; a clear sky is Sunny while the sun is up, and Clear otherwise."""
    best: tuple[int, Finding[Weather]] | None = None
    for sentence in sentences:
        if re.search(r"\b(?:forecast|airbag|occupant)\b", sentence.plain):
            continue
        plain = _OTHER_SENSE.sub(" ", sentence.plain)
        for rank, (weather, confidence, words) in enumerate(_COMPILED_SKY):
            match = words.search(plain)
            if match and (best is None or rank < best[0]):
                clear = Weather.SUNNY if time is Time.DAYTIME and sun_is_up else Weather.CLEAR
                best = rank, Finding(weather or clear, confidence, sentence.text, f"the words '{match[0].strip()}'")
                break
    if best is not None:
        return best[1]
    for sentence in sentences:
        if _COVERED.search(sentence.plain):
            return Finding(Weather.SNOWY, 0.4, sentence.text, "snow lies, though none is said to fall")
    if any(re.search(r"\bwet\b", sentence.plain) for sentence in sentences):
        return nothing("the road is wet, but the weather at the time is not mentioned")
    return nothing("the weather is not mentioned")
