"""The crashes that a command was given: reports, read by the embedded backend, or files of the scenario language."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from roadmend.core.errors import InputError, RoadmendError
from roadmend.language.chat import Image
from roadmend.safe.dsl import CrashScenario
from roadmend.safe.dsl_file import load_crash_scenario
from roadmend.safe.embedded import EmbeddedExtractor
from roadmend.safe.extraction import Extraction
from roadmend.safe.report import (
    EVIDENCE,
    LANGUAGE_SUFFIXES,
    CrashReport,
    case_of,
    find_reports,
    load_report,
    looking_through,
)


@dataclass(frozen=True, slots=True)
class CrashCase:
    """One crash: what happened, or why that could not be read.

    Attributes:
        name: of the report.
        crash: what it says; None if it could not be read.
        sketch: picture that belongs to it.
        problem: one line, empty where there is a crash.
        report: that it was read from; None where it comes from a file of the scenario language.
        extraction: what was read, with what each field rests on.
    """

    name: str
    crash: CrashScenario | None
    sketch: Image | None = None
    problem: str = ""
    report: CrashReport | None = None
    extraction: Extraction | None = None


def gather_cases(paths: Sequence[Path]) -> list[CrashCase]:
    """All cases of files and folders, by name; one that cannot be read is a case too.

    A folder is a report, or holds reports, or holds files of the scenario language. A file is a report if it ends in
    ``.txt``, else of the scenario language.

    Raises:
        InputError: a path holds nothing of the kind, a folder cannot be read, or two cases have one name.
    """
    cases: dict[str, CrashCase] = {}
    for path in paths:
        for case in _cases_of(path):
            if case.name in cases:
                raise InputError(str(path), f"there are two cases {case.name!r}", "rename one of them")
            cases[case.name] = case
    return [cases[name] for name in sorted(cases)]


def _cases_of(path: Path) -> list[CrashCase]:
    with looking_through():
        files = _of_language(path)
    if files:
        return [_from_language(each) for each in files]
    return [_from_report(each) for each in find_reports(path)]


def _of_language(path: Path) -> list[Path]:
    """The files of the scenario language that a path stands for; none where it is, or may hold, a report."""
    if path.is_file() and path.suffix.lower() != ".txt":
        return [path]
    entries = [each for each in sorted(path.iterdir()) if not each.name.startswith(".")] if path.is_dir() else []
    if any(each.is_dir() or each.suffix.lower() == ".txt" for each in entries):
        return []
    return [each for each in entries if each.suffix.lower() in LANGUAGE_SUFFIXES and not each.stem.endswith(EVIDENCE)]


def _from_language(path: Path) -> CrashCase:
    try:
        return CrashCase(path.stem, load_crash_scenario(path))
    except RoadmendError as error:
        return CrashCase(path.stem, None, problem=str(error))


def _from_report(path: Path) -> CrashCase:
    name = case_of(path)
    report = None
    try:
        report = load_report(path)
        extraction = EmbeddedExtractor().extract(report)
    except RoadmendError as error:
        return CrashCase(name, None, report.sketch if report is not None else None, str(error), report)
    return CrashCase(name, extraction.scenario, report.sketch, "", report, extraction)
