"""A summary as sentences in which the same thing is always put the same way."""

import re
from dataclasses import dataclass

from roadmend.safe.reading.numerals import numerals_to_digits
from roadmend.safe.reading.vehicle_names import name_vehicles

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
