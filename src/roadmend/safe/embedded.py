"""The embedded backend: rules for English, no language model, no network, the same answer every time."""

import re
from collections.abc import Callable
from dataclasses import replace
from enum import StrEnum
from typing import Any

from roadmend.language.chat import Image
from roadmend.safe.dsl import CrashScenario
from roadmend.safe.extraction import Extraction, ExtractionError, FieldEvidence, Step, Watch, unwatched
from roadmend.safe.reading.reader import read_summary
from roadmend.safe.reading.text import Finding
from roadmend.safe.report import CrashReport
from roadmend.safe.sketch_text import SketchText, posted_limit, read_sketch

_WORDS = re.compile(r"[^\W\d_]+")
_ENGLISH = """
the a an of to in on at and was were is are it its by from with that this for as had has which but not or into
be been when while after before both one two
"""
_FUNCTION_WORDS = frozenset(_WORDS.findall(_ENGLISH))
_LEAST_ENGLISH = 0.2  # share of function words; in English prose it is near one half
_TRUST_IN_SKETCH = 0.6
_FEWEST_WORDS = 12  # below that, shares say nothing
_OTHERS = re.compile(
    r"\b(?:struck|hit|hitting|striking|ran over|collided with|impacted|contacted)\b[^.]{0,60}?\b(pedestrians?|"
    r"bicyclists?|cyclists?|pedalcyclists?|deer|animal|cow|horse|moose|dog|motorcyclists?|scooter)\b",
    re.IGNORECASE,
)


class EmbeddedExtractor:
    """Reads the summary; of the sketch no more than a posted limit about which the summary is silent.

    Args:
        read: gives the words of a sketch.
    """

    def __init__(self, read: Callable[[Image], SketchText] = read_sketch) -> None:
        self.read = read

    def extract(self, report: CrashReport, watch: Watch = unwatched) -> Extraction:
        """Read one report.

        Raises:
            ExtractionError: the summary is not in English, or speaks of no vehicle.
        """
        watch(Step("read"))
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
        scenario, sketch = reading.scenario, "there is none"
        if report.sketch is not None and all(vehicle.speed_limit_mph is not None for vehicle in scenario.vehicles):
            sketch = "not read: this backend looks for nothing but speed limits there, and the summary has them"
        elif report.sketch is not None:
            written = self.read(report.sketch)
            sketch = written.note
            limit = posted_limit(written.text or "")
            if limit is not None:
                found = FieldEvidence(limit, None, _TRUST_IN_SKETCH, f"the sketch says {limit} mph")
                scenario, evidence = _with_limit(scenario, evidence, found)
        return Extraction(scenario, evidence, sketch, tuple(notes))


def _with_limit(
    scenario: CrashScenario, evidence: dict[str, FieldEvidence], found: FieldEvidence
) -> tuple[CrashScenario, dict[str, FieldEvidence]]:
    """Give the vehicles the limit of the sketch that have none from the summary."""
    vehicles = []
    filled = dict(evidence)
    for index, vehicle in enumerate(scenario.vehicles):
        is_open = vehicle.speed_limit_mph is None
        vehicles.append(replace(vehicle, speed_limit_mph=found.value) if is_open else vehicle)
        if is_open:
            filled[f"vehicles[{index}].speed_limit_mph"] = found
    return replace(scenario, vehicles=tuple(vehicles)), filled


def _limits(report: CrashReport, vehicles: int) -> list[str]:
    others = {match[1].lower() for match in _OTHERS.finditer(report.summary)}
    notes = [f"a {name} takes part, for which the scenario language has no words" for name in sorted(others)]
    if vehicles == 1:
        notes.append("one vehicle alone: there is no other to collide with")
    return notes


def _evidence(finding: Finding[Any]) -> FieldEvidence:
    value = finding.value.value if isinstance(finding.value, StrEnum) else finding.value
    return FieldEvidence(value, finding.sentence, round(finding.confidence, 2), finding.reason)
