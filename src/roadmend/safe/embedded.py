"""The embedded backend: a parser of English, rules and a small trained network; no language model, nothing over a network."""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from enum import StrEnum
from typing import Any

from roadmend.language.chat import Image
from roadmend.safe.claims import AnyClaim, Box, Cast, Claim, Span
from roadmend.safe.dsl import StruckObject
from roadmend.safe.extraction import Extraction, ExtractionError, FieldEvidence, Step, Watch, unwatched
from roadmend.safe.reading.assembly import ReportReading
from roadmend.safe.reading.english import engine
from roadmend.safe.reading.lexicon import is_known
from roadmend.safe.reading.reader import SummaryClaims, assemble, read_claims
from roadmend.safe.reading.weighing import JudgedField
from roadmend.safe.report import CrashReport
from roadmend.safe.sketch_claims import SketchClaims, claims_of_sketch
from roadmend.safe.trained.trained_claims import trained_claims, trained_reader

ReadSketch = Callable[[Image, Cast], SketchClaims]
ReadText = Callable[[str, SummaryClaims], tuple[SummaryClaims, Sequence[AnyClaim]]]

_WORDS = re.compile(r"[^\W\d_]+")
_ENGLISH = """
the a an of to in on at and was were is are it its by from with that this for as had has which but not or into
be been when while after before both one two i my he she we you they there then his her so if just
"""
_SHORTHAND = frozenset(
    [
        "nb",
        "sb",
        "eb",
        "wb",
        "veh",
        "v",
        "unit",
        "vs",
        "op",
        "rd",
        "st",
        "psl",
        "mph",
        "ln",
        "hwy",
        "driver",
        "front",
        "rear",
        "left",
        "right",
    ]
)
_FUNCTION_WORDS = frozenset(_WORDS.findall(_ENGLISH)) | _SHORTHAND
_LEAST_ENGLISH = 0.2  # share of function words; in English prose it is near one half
_LEAST_KNOWN = 0.35  # share of words that the tables know: shorthand has few function words, and many of these
_FEWEST_WORDS = 12  # below that, shares say nothing
_IN_DOUBT = 0.6  # a field below that is named in the notes
_SECOND = 0.1  # a second reading that is told


class EmbeddedExtractor:
    """Reads the summary by rules and by a trained network, and the sketch; one scene has to satisfy what they claim.

    Args:
        read_sketch: makes claims of a sketch, given the summary's cast.
        read_text: makes more claims of the summary, given those of the rules, whose cast it may add to; None for none.
        solver: let the fields decide about each other; without, each stands alone, to see what that is good for.
    """

    def __init__(
        self,
        read_sketch: ReadSketch = claims_of_sketch,
        read_text: ReadText | None = trained_claims,
        *,
        solver: bool = True,
    ) -> None:
        self.read_sketch = read_sketch
        self.read_text = read_text
        self.solver = solver

    @property
    def identity(self) -> str:
        """The parser and the network by name, version and digest, for a result to say."""
        return engine() + (f", {trained_reader()}" if self.read_text is trained_claims else "")

    def extract(self, report: CrashReport, watch: Watch = unwatched) -> Extraction:
        """Read one report.

        Raises:
            ExtractionError: the summary is not in English, or speaks of no vehicle.
            InputError: the parser of English is not installed.
        """
        watch(Step("read"))
        words = [word.lower() for word in _WORDS.findall(report.summary)]
        share = sum(word in _FUNCTION_WORDS for word in words) / max(len(words), 1)
        known = sum(word in _FUNCTION_WORDS or is_known(word) for word in words) / max(len(words), 1)
        if len(words) >= _FEWEST_WORDS and share < _LEAST_ENGLISH and known < _LEAST_KNOWN:
            raise ExtractionError("the summary does not read as English; the openai backend may know its language")
        said = read_claims(report.summary)
        if said is None:
            raise ExtractionError("the summary speaks of no vehicle; is it the report of a crash?")
        more, found = list[AnyClaim](), said
        if self.read_text is not None:
            said, claims = self.read_text(report.summary, said)
            more += claims
        sketch = "there is none"
        if report.sketch is not None:
            seen = self.read_sketch(report.sketch, said.cast)
            more += seen.claims
            sketch = seen.note
        reading = assemble(said, more, solver=self.solver)
        evidence = {name: _evidence(finding, report.summary) for name, finding in reading.findings.items()}
        notes = [*report.notes, *_limits(said, reading), *_doubts(reading.findings)]
        notes += [
            f"vehicle {each.number} ({each.names[0] if each.names else 'unnamed'}) was found by the trained reader alone"
            for each in said.cast[len(found.cast) :]
        ]
        notes += [f"vehicle {said.cast[place].number} touched nothing and was left out" for place in reading.left_out]
        return Extraction(reading.scenario, evidence, sketch, tuple(notes), reader=self.identity)


def _limits(said: SummaryClaims, reading: ReportReading) -> Iterator[str]:
    impacts = reading.scenario.impacts
    for name in said.others:
        if name == "animal" and any(each.object is StruckObject.ANIMAL for each in impacts):
            continue
        yield f"a {name} takes part, for which the scenario language has no words"
    if len(reading.scenario.vehicles) == 1:
        yield "one vehicle alone: whoever drives the ego looks on"


def _doubts(findings: Mapping[str, JudgedField]) -> Iterator[str]:
    for name, finding in findings.items():
        if finding.value is not None and finding.confidence < _IN_DOUBT and not name.endswith("manoeuvre"):
            yield f"{name} is in doubt: {_plain(finding.value)} with confidence {finding.confidence:.2f}"


def _plain(value: Any) -> Any:
    return value.value if isinstance(value, StrEnum) else value


def _evidence(finding: JudgedField, summary: str) -> FieldEvidence:
    best = finding.claims[0] if finding.claims and finding.value is not None else None
    where = best.where if best is not None else None
    span = (where.start, where.end) if isinstance(where, Span) else None
    box = (where.left, where.top, where.right, where.bottom) if isinstance(where, Box) else None
    if best is not None:
        reason = best.reason
    elif finding.value is not None:
        reason = "nothing is said of it; it follows from the rest, or is the usual case"
    else:
        reason = "the report does not say"
    confidence = round(finding.confidence, 2) if finding.value is not None else 0.0
    sentence = _sentence(summary, span) if span is not None else None
    return FieldEvidence(_plain(finding.value), sentence, confidence, reason, span, box, tuple(_against(finding)))


def _against(finding: JudgedField) -> Iterator[str]:
    told: set[Any] = set()
    for claim in sorted(finding.against, key=lambda each: -each.confidence):
        if claim.value not in told and claim.confidence > 0.5:
            told.add(claim.value)
            yield _told(claim)
    if finding.second is not None and finding.second[1] >= _SECOND and finding.second[0] not in told:
        yield f"second reading: {_plain(finding.second[0])} with confidence {finding.second[1]:.2f}"


def _told(claim: Claim) -> str:
    return f"the {claim.source.value} also speaks for {_plain(claim.value)}: {claim.reason}"


def _sentence(summary: str, span: tuple[int, int]) -> str:
    """The sentence, or what stands between line breaks, around a piece of the summary."""
    start = max((match.end() for match in re.finditer(r"[.!?]\s+|\n", summary[: span[0]])), default=0)
    end = re.search(r"[.!?](?=\s|$)|\n", summary[span[1] :])
    return summary[start : span[1] + (end.end() if end else len(summary))].strip()
