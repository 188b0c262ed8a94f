"""The embedded backend: rules for English, no model, no network, the same answer every time."""

import re
from enum import StrEnum
from typing import Any

from roadmend.safe.extraction import Evidence, Extraction, ExtractionError
from roadmend.safe.reading.finding import Finding
from roadmend.safe.reading.reader import read_summary
from roadmend.safe.report import CrashReport

_WORDS = re.compile(r"[^\W\d_]+")
_FUNCTION_WORDS = frozenset(
    ["the", "a", "an", "of", "to", "in", "on", "at", "and", "was", "were", "is", "are", "it", "its", "by", "from", "with", "that", "this", "for", "as", "had", "has", "which", "but", "not", "or", "into", "be", "been", "when", "while", "after", "before", "both", "one", "two"]
)
_LEAST_ENGLISH = 0.2  # share of function words; in English prose it is near one half
_FEWEST_WORDS = 12  # below that, shares say nothing
_OTHERS = re.compile(
    r"\b(?:struck|hit|hitting|striking|ran over|collided with|impacted|contacted)\b[^.]{0,60}?"
    r"\b(pedestrians?|bicyclists?|cyclists?|pedalcyclists?|deer|animal|cow|horse|moose|dog|motorcyclists?|scooter)\b",
    re.IGNORECASE,
)


class EmbeddedExtractor:
    """Reads the summary; the sketch it cannot read, and says so."""

    def extract(self, report: CrashReport) -> Extraction:
        """Read one report.

        Raises:
            ExtractionError: the summary is not in English, or speaks of no vehicle.
        """
        words = [word.lower() for word in _WORDS.findall(report.summary)]
        share = sum(word in _FUNCTION_WORDS for word in words) / max(len(words), 1)
        if len(words) >= _FEWEST_WORDS and share < _LEAST_ENGLISH:
            raise ExtractionError("the summary does not read as English; the openai backend may know its language")
        reading = read_summary(report.summary)
        if reading is None:
            raise ExtractionError("the summary speaks of no vehicle; is it the report of a crash?")
        notes = [*report.notes, *_limits(report, len(reading.scenario.vehicles))]
        notes += [f"vehicle {number} touched nothing and was left out" for number in reading.left_out]
        evidence = {name: _evidence(finding) for name, finding in reading.findings.items()}
        sketch = "not read: the embedded backend reads text only" if report.sketch is not None else "there is none"
        return Extraction(reading.scenario, evidence, sketch, tuple(notes))


def _limits(report: CrashReport, vehicles: int) -> list[str]:
    others = {match[1].lower() for match in _OTHERS.finditer(report.summary)}
    notes = [f"a {name} takes part, for which the scenario language has no words" for name in sorted(others)]
    if vehicles == 1:
        notes.append("one vehicle alone: there is no other to collide with")
    return notes


def _evidence(finding: Finding[Any]) -> Evidence:
    value = finding.value.value if isinstance(finding.value, StrEnum) else finding.value
    return Evidence(value, finding.sentence, round(finding.confidence, 2), finding.reason)
