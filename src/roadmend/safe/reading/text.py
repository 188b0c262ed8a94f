"""A summary as sentences in which the same thing is always put the same way."""

import re
from dataclasses import dataclass
from typing import Generic, TypeVar

MAX_SENTENCE = 1500  # [characters] longer ones are cut: no rule looks that far, and time stays bounded

_CHARACTERS = str.maketrans(
    {
        "\u2018": "'",
        "\u2019": "'",
        "\u02bc": "'",
        "\u201c": '"',
        "\u201d": '"',
        "\u2010": "-",
        "\u2011": "-",
        "\u2012": "-",
        "\u2013": "-",
        "\u2014": " - ",
        "\u2026": "...",
        "\u00a0": " ",
    }
)
_ABBREVIATIONS = re.compile(
    r"\b(approx|appr|no|nos|st|ave|blvd|rd|hwy|mr|mrs|ms|dr|jr|sr|vs|ft|veh|ca|etc|deg|min|u\.s|e\.g|i\.e)\.(?=\s)",
    re.IGNORECASE,
)
_SENTENCE_END = re.compile(
    r"(?<=[.!?;])[\"')\]]*\s+(?=[\"'(\[]?[A-Z0-9#])"
    r"|(?<=[a-z)][.!?])\)?\.?(?=[A-Z][a-z]+ )"  # the space was forgotten
    r"|\n\s*\n|\n(?=[A-Z\-*\u2022])"
)
_SPELLINGS = tuple(
    (re.compile(pattern), put)
    for pattern, put in (
        (r"\b(v\d) - ((?:an?|the) (?:(?! - )[^.;]){2,60}) - ", r"\1, \2, "),
        (r"\btravell(?=ing|ed)", "travel"),
        (r"\bmaneuver|\bmanouver", "manoeuvre"),
        (r"\bcentre ?line|\bcenter ?line", "centerline"),
        (
            r"(?<=\d)\s*(?:km ?/ ?hr?|kmh|k\.?p\.?h\.?|km?mph|kmph|kilomet(?:er|re)s? (?:per|an) hour)(?![a-z])",
            " km/h",
        ),
        (r"(?<=\d)[ -]*(?:m\.p\.h\.?|mph|miles? (?:per|an) hour|mi/h)(?![a-z])", " mph"),
        (r"(\blimit(?: (?:is|was|of|at))?:? [1-9][05])(?![\d.,]*\d| ?(?:mph|mi|km|k\.?p|%|feet|met))", r"\1 mph"),
        (r"\b(north|south|east|west)[ -](?=bound\b)", r"\1"),
        (r"\b(north|south|east|west)(?:ern|ward|wards|wardly)\b", r"\1"),
        (r"\bn/?b\b", "northbound"),
        (r"\bs/?b\b", "southbound"),
        (r"\be/?b\b", "eastbound"),
        (r"\bw/?b\b", "westbound"),
        (r"\b(north|south|east|west)(?:bound)? and (north|south|east|west)bound\b", r"\1bound and \2bound"),
        (r"\bleft-?hand(?:ed)?\b", "left"),
        (r"\bright-?hand(?:ed)?\b", "right"),
        (r"\bmazda(?=[2356]\b)", "mazda "),
        (r"\bon-? ?ramp\b", "on-ramp"),
        (r"\boff-? ?ramp\b", "off-ramp"),
        (r"\bpick-? up\b|\bpick-up\b", "pickup"),
        (r"\bmini-van\b|\bmini van\b", "minivan"),
        (r"\bcross-over\b", "crossover"),
        (r"\s+", " "),
    )
)


@dataclass(frozen=True, slots=True)
class Sentence:
    """One sentence.

    Attributes:
        text: as the report puts it.
        plain: the same in lower case, numerals as digits, vehicle number 1 always as ``v1``, one spelling for all.
    """

    text: str
    plain: str


def split_sentences(summary: str) -> tuple[str, ...]:
    """The sentences of a summary, as they stand there."""
    text = summary.replace("\\u2019", "'").translate(_CHARACTERS)
    text = _ABBREVIATIONS.sub("\\1\u2024", text)  # a full stop that ends nothing
    parts = (" ".join(part.split()).replace("\u2024", ".") for part in _SENTENCE_END.split(text) if part)
    return tuple(part[start : start + MAX_SENTENCE] for part in parts for start in range(0, len(part), MAX_SENTENCE))


def read_sentences(summary: str) -> tuple[Sentence, ...]:
    """The sentences of a summary, with their plain form beside."""
    return tuple(Sentence(text, _plain(text)) for text in split_sentences(summary))


def _plain(text: str) -> str:
    plain = numerals_to_digits(name_vehicles(text))
    for pattern, put in _SPELLINGS:
        plain = pattern.sub(put, plain)
    return plain.strip()


Value_co = TypeVar("Value_co", covariant=True)


@dataclass(frozen=True, slots=True)
class Finding(Generic[Value_co]):
    """A value, or why there is none.

    Attributes:
        value: what was read; None where the report does not say.
        confidence: from 0 to 1; that of the absence where there is no value.
        sentence: the sentence it rests on, as the report puts it; None where it rests on none.
        reason: by which rule it was read, or why there is no value.
    """

    value: Value_co | None
    confidence: float
    sentence: str | None
    reason: str


def nothing(reason: str) -> Finding[Value_co]:
    """No value, and why."""
    return Finding(None, 1.0, None, reason)


_ONES = (
    "zero",
    "one",
    "two",
    "three",
    "four",
    "five",
    "six",
    "seven",
    "eight",
    "nine",
    "ten",
    "eleven",
    "twelve",
    "thirteen",
    "fourteen",
    "fifteen",
    "sixteen",
    "seventeen",
    "eighteen",
    "nineteen",
)
_TENS = ("twenty", "thirty", "forty", "fifty", "sixty", "seventy", "eighty", "ninety")
_VALUES = {word: value for value, word in enumerate(_ONES)} | {word: 10 * (i + 2) for i, word in enumerate(_TENS)}

_TEN = "|".join(_TENS)
_ONE = "|".join(sorted(_ONES, key=len, reverse=True))
_NUMERAL = re.compile(rf"\b(?:(?:({_TEN})(?:[ -]({'|'.join(_ONES[1:10])}))?)|({_ONE}))\b")


def numerals_to_digits(text: str) -> str:
    """A text in lower case with 'two' as 2 and 'thirty-five' as 35."""
    return _NUMERAL.sub(_digits, text)


def _digits(match: re.Match[str]) -> str:
    ten, one, alone = match.groups()
    return str(_VALUES[alone]) if alone else str(_VALUES[ten] + _VALUES.get(one, 0))


_WORDS = ("one", "two", "three", "four", "five", "six", "seven", "eight", "nine")
_NUMBER = rf"(?:\#|no\.?|number)?\s*\#?\s*(?P<number>{'|'.join(_WORDS)}|[1-9](?!\d|\.\d|,\d{1, 3}\b))"
_KIND = r"(?:vehicle|veh\.?|unit|car|truck|driver|automobile|motorist|operator|v|d)s?"
_NOT_A_NUMBER = (
    r"(?!\s*(?:lane|door|mph|km|%|st\b|nd\b|rd\b|th\b|of\b|hundred|quarter|occupant|other|feet|met(?:er|re)|car|"
    r"passenger|more|seconds?|minutes?|hours?|years?)|-(?!\w*\s*case))"
)
_REFERENCE = re.compile(rf"\b{_KIND}[\s-]*{_NUMBER}\b{_NOT_A_NUMBER}")
_FURTHER = re.compile(
    rf"(v\d(?:'s)?\s*(?:,\s*and|,\s*or|and|or|&|,)\s*){_NUMBER}\b{_NOT_A_NUMBER}(?=\s*(?:,|\.|;|and\b|or\b|\w+ed\b|"
    r"were\b|\w+\s+\w+))"
)
_LETTER = re.compile(r"\b([Vv]ehicle|[Cc]ar|[Uu]nit|VEHICLE|CAR|UNIT) ([A-F])\b(?![\w'/-])")
_ORDINAL = re.compile(r"\b(?:the|a) (first|second|third) (?:vehicle|car|automobile)\b")
_DEFINES_CASE = re.compile(
    r"\bv(\d)\s*[(,;:/=-]*\s*(?:the\s+)?(?:case|subject)[- ]vehicle|(?:case|subject) vehicle\s*,?\s*\(\s*v(\d)"
)
_CASE = re.compile(r"\b(?:the|this) (?:case|subject) vehicle\b(?!\s*\()")


def name_vehicles(text: str) -> str:
    """A text in which every numbered vehicle is called v and its number; the result is in lower case."""
    plain = _LETTER.sub(lambda match: f"v{'ABCDEF'.index(match[2]) + 1}", text).lower()
    plain = _REFERENCE.sub(lambda match: f"v{_value(match['number'])}", plain)
    for _ in _WORDS:  # each turn names one more vehicle of a list
        longer = _FURTHER.sub(lambda match: f"{match[1]}v{_value(match['number'])}", plain)
        if longer == plain:
            break
        plain = longer
    return _ORDINAL.sub(lambda match: f"v{('first', 'second', 'third').index(match[1]) + 1}", plain)


def case_vehicle(plain: str) -> int:
    """Number of the vehicle that a text in plain form calls the case vehicle; 1 where it does not say."""
    match = _DEFINES_CASE.search(plain)
    return int(match[1] or match[2]) if match else 1


def name_case_vehicle(plain: str, number: int) -> str:
    """A text in plain form in which 'the case vehicle' has its number."""
    return _CASE.sub(f"v{number}", plain)


def _value(numeral: str) -> int:
    return int(numeral) if numeral.isdigit() else _WORDS.index(numeral) + 1
