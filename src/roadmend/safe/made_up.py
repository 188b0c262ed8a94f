"""Values of an answer for which a report has no words at all, whatever else it says."""

import functools
import importlib.resources
import re
from collections.abc import Mapping, Sequence
from typing import Any

from roadmend.core.yaml_file import parse_yaml
from roadmend.safe.dsl import KM_PER_MILE

_NUMBER = re.compile(r"\d+")
_TENS = re.compile(r"\b(?:twen|thir|for|fif|six|seven|eigh|nine)ty\b|\bhundred\b", re.IGNORECASE)
_TABLES = {"striking_side": "sides", "struck_side": "sides", "action": "actions", "weather": "weather"}


def why_made_up(field: str, value: Any, summary: str) -> str | None:
    """What a text lacks that would be there if a field had such a value; None if nothing does.

    Only for reports without a sketch: what the text lacks may be seen there.

    Args:
        field: as the JSON form calls it.
        value: of the field.
        summary: the text.
    """
    name = field.rpartition(".")[2]
    if name == "speed_limit_mph":
        return None if value is None or _has_limit(summary, value) else "the text has no such number"
    words = _tables().get(_TABLES.get(name, ""), {}).get(value) if isinstance(value, str) else None
    if not words or re.search(rf"\b(?:{'|'.join(map(re.escape, words))})", summary, re.IGNORECASE):
        return None
    return f"the text has no word for {value}"


def _has_limit(summary: str, mph: float) -> bool:
    """Whether a number stands there that is the limit in one of the two units; numbers in words are not looked into."""
    if _TENS.search(summary):
        return True
    numbers = [int(match[0][:6]) for match in _NUMBER.finditer(summary)]
    return any(abs(number - mph) <= 0.5 or abs(number - mph * KM_PER_MILE) <= 2.5 for number in numbers)


@functools.cache
def _tables() -> Mapping[str, Mapping[str, Sequence[str]]]:
    file = importlib.resources.files(__package__).joinpath("needed_words.yaml")
    tables: Mapping[str, Mapping[str, Sequence[str]]] = parse_yaml(file.read_text(encoding="utf-8"), file.name)
    return tables
