"""Crash reports read by the embedded backend for a benchmark: with and without the sketch, kept on disk as they come."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from roadmend.core.errors import RoadmendError
from roadmend.core.fanout import fan_out
from roadmend.core.journal import Journal, entry_key
from roadmend.safe.cases import CrashCase
from roadmend.safe.dsl_data import dump_data, parse_data
from roadmend.safe.embedded import EmbeddedExtractor
from roadmend.safe.report import CrashReport, load_report
from roadmend.safe.sketch_claims import is_sketch_read
from roadmend.safe.trained.trained_claims import trained_claims, trained_reader

_FORMAT = "roadmend-bench-reading/1"


@dataclass(frozen=True, slots=True)
class ReadCrash:
    """One report as it was read.

    Attributes:
        name: of the report.
        data: the scenario as plain data; None if it could not be read.
        confidence: of the fields, by their path, where the reader gives one.
        problem: why it could not be read.
    """

    name: str
    data: Mapping[str, Any] | None
    confidence: Mapping[str, float]
    problem: str = ""

    def case(self, report: CrashReport | None = None) -> CrashCase:
        """As the rest of the program takes it."""
        crash = None if self.data is None else parse_data(self.data, self.name)
        return CrashCase(self.name, crash, report.sketch if report is not None else None, self.problem)


def read_crashes(
    paths: Sequence[Path],
    work: Path,
    workers: int,
    told: Callable[[int], None],
    *,
    sketch: bool = True,
    solver: bool = True,
    trained: bool = True,
) -> list[ReadCrash]:
    """Read reports, or take what an earlier call has read.

    Args:
        paths: of the reports.
        work: folder to keep what was read in.
        workers: processes.
        told: hears how many are done.
        sketch: look at the sketch too.
        solver: let the reader's consistency solver decide.
        trained: let the trained reader claim, too.

    Raises:
        InputError: a report's files are broken.
    """
    reports = [load_report(path) for path in paths]
    reports = [report if sketch else replace(report, sketch=None) for report in reports]
    decided = (sketch, solver, trained_reader() if trained else None, is_sketch_read())
    keys = [entry_key([__name__], report.case, report.digest(), *decided) for report in reports]
    with Journal(work / "readings.jsonl", _FORMAT) as journal:
        missing = [(key, report) for key, report in zip(keys, reports, strict=True) if journal.get(key) is None]
        done = len(reports) - len(missing)
        told(done)
        with fan_out(workers, len(missing)) as mapper:
            answers = mapper(partial(_read, solver=solver, trained=trained), [report for _, report in missing])
            for (key, _), answer in zip(missing, answers, strict=True):
                journal.add(key, answer)
                done += 1
                told(done)
        found = [journal.get(key) for key in keys]
    return [ReadCrash(each["name"], each["data"], each["confidence"], each["problem"]) for each in found if each]


def _read(report: CrashReport, *, solver: bool, trained: bool) -> dict[str, Any]:
    reader = EmbeddedExtractor(read_text=trained_claims if trained else None, solver=solver)
    try:
        extraction = reader.extract(report)
    except RoadmendError as error:
        return {"name": report.case, "data": None, "confidence": {}, "problem": str(error)}
    confidence = {
        path: evidence.confidence for path, evidence in extraction.evidence.items() if evidence.confidence is not None
    }
    return {"name": report.case, "data": dump_data(extraction.scenario), "confidence": confidence, "problem": ""}
