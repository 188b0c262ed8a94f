"""What comes out of a crash report, and the ways to get it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

from roadmend.core.errors import RoadmendError
from roadmend.language.exchange import Exchange
from roadmend.safe.dsl import CrashScenario
from roadmend.safe.report import CrashReport


class ExtractionError(RoadmendError):
    """A report was read, and no scenario came out."""

    def __init__(self, problem: str, exchanges: tuple[Exchange, ...] = ()) -> None:
        super().__init__(problem)
        self.exchanges = exchanges


@dataclass(frozen=True, slots=True)
class Witness:
    """What one source says of a field.

    Attributes:
        source: who says it.
        value: of the field, as the JSON form has it; None where the source only says that another value is wrong.
        confidence: from 0 to 1.
        ground: what the source goes by.
        sentence: of the report that it goes by, where there is one.
    """

    source: str
    value: Any
    confidence: float
    ground: str = ""
    sentence: str | None = None


@dataclass(frozen=True, slots=True)
class FieldEvidence:
    """What a field rests on.

    Attributes:
        value: of the field, as the JSON form has it.
        sentence: of the report; None where the field rests on none.
        confidence: from 0 to 1; None where the backend gives none.
        reason: by what rule, or why there is no value.
        span: first and last character of the summary that it was read from, the last not included.
        box: left, top, right and bottom of what it was read from in the sketch [pixels].
        doubts: what speaks for another value, and the second reading.
        disputed: all that was said of it, where sources do not agree; else empty.
    """

    value: Any
    sentence: str | None
    confidence: float | None
    reason: str
    span: tuple[int, int] | None = None
    box: tuple[float, float, float, float] | None = None
    doubts: tuple[str, ...] = ()
    disputed: tuple[Witness, ...] = ()


@dataclass(frozen=True, slots=True)
class Extraction:
    """A scenario and where it comes from.

    Attributes:
        scenario: what happened.
        evidence: by field, as the JSON form calls it ("vehicles[0].model").
        sketch: whether the sketch was read, and if not, why.
        notes: whatever else is to be known, the limits of the backend among it.
        exchanges: with a language model, in order.
        reader: what parsed the text, by name and version; empty where a language model read it.
    """

    scenario: CrashScenario
    evidence: Mapping[str, FieldEvidence]
    sketch: str
    notes: tuple[str, ...] = ()
    exchanges: tuple[Exchange, ...] = field(default=(), repr=False)
    reader: str = ""


@dataclass(frozen=True, slots=True)
class Step:
    """What is about to be done.

    Attributes:
        stage: its name.
        attempt: from 1.
        total: attempts that the stage may take.
    """

    stage: str
    attempt: int = 1
    total: int = 1


Watch = Callable[[Step], None]  # called before each step; what it raises ends the work


def unwatched(_: Step) -> None:
    """Nobody watches."""


class Extractor(Protocol):
    """Reads crash reports."""

    def extract(self, report: CrashReport, watch: Watch = unwatched) -> Extraction:
        """Read one report; may be called from several threads.

        Raises:
            ExtractionError: no scenario came out.
            ForeignError: code from outside that it asks failed.
        """
