"""One value that was read from a report, with what it rests on."""

from dataclasses import dataclass
from typing import Generic, TypeVar

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
