"""Failure patterns to messages and back."""

import math
from array import array
from collections.abc import Sequence
from dataclasses import fields
from typing import Any

from roadmend_msgs import msg

from roadmend.core.errors import InputError
from roadmend.sera.pattern import FailurePattern, Where, Who, Why, parse_patterns

_PARTS = {"where": Where, "who": Who, "why": Why}  # the message has their fields side by side
_ANY: dict[str, float] = {"lanes": 0, "speed_limit": 0.0, "ego_speed": -1.0}  # of texts it is the empty one


def pattern_message_of(pattern: FailurePattern) -> msg.FailurePattern:
    """A pattern as a message."""
    message = msg.FailurePattern(name=pattern.name, words=pattern.words, outcome=pattern.what or "")
    for part, kind in _PARTS.items():
        for field in fields(kind):
            value = getattr(getattr(pattern, part), field.name)
            setattr(message, field.name, _ANY.get(field.name, "") if value is None else value)
    message.evidence_bag = [each.episode for each in pattern.evidence]
    message.evidence_scenario = [each.scenario for each in pattern.evidence]
    message.evidence_time = array("d", [math.nan if each.time is None else each.time for each in pattern.evidence])
    message.evidence_note = [each.note for each in pattern.evidence]
    return message


def patterns_of(messages: Sequence[msg.FailurePattern]) -> list[FailurePattern]:
    """Patterns from messages.

    Raises:
        InputError: a field has a value that it cannot have, or the lists of evidence differ in length.
    """
    return parse_patterns([_plain(message) for message in messages], "patterns")


def _plain(message: msg.FailurePattern) -> dict[str, Any]:
    times = [None if math.isnan(time) else time for time in message.evidence_time]
    columns = (message.evidence_bag, message.evidence_scenario, times, message.evidence_note)
    try:
        rows = [*zip(*columns, strict=True)]
    except ValueError:
        lengths = ", ".join(str(len(column)) for column in columns)
        raise InputError(
            f"pattern {message.name!r}", f"its lists of evidence differ in length ({lengths})", "fill all or none"
        ) from None
    return {
        "name": message.name,
        "words": message.words,
        "what": message.outcome or None,
        **{part: {field.name: _value(message, field.name) for field in fields(kind)} for part, kind in _PARTS.items()},
        "evidence": [dict(zip(("episode", "scenario", "time", "note"), row, strict=True)) for row in rows],
    }


def _value(message: msg.FailurePattern, name: str) -> Any:
    value = getattr(message, name)
    if name not in _ANY:
        return value or None
    if not math.isfinite(value):
        raise InputError(f"pattern {message.name!r}", f"{name} is {value}", f"give a number, or {_ANY[name]:g} for any")
    return value if value > _ANY[name] and value >= 0.0 else None
