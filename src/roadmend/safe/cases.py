"""Finds the crash reports and files of the scenario language that a command was given."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from roadmend.core.errors import InputError, RoadmendError
from roadmend.safe.dsl import CrashScenario
from roadmend.safe.dsl_file import load_crash_scenario
from roadmend.safe.reading.reader import read_summary

_FILES = {".json", ".yaml", ".yml", ".safe"}
_GENERIC = {"scenario", "crash"}  # stems of files that are named after their folder
_SUMMARY = "summary.txt"


@dataclass(frozen=True, slots=True)
class Case:
    """One crash: what happened, or why that could not be read.

    Attributes:
        name: of the report.
        crash: what it says; None if it could not be read.
        sketch: picture that belongs to it.
        problem: one line, empty where there is a crash.
    """

    name: str
    crash: CrashScenario | None
    sketch: Path | None = None
    problem: str = ""


def gather_cases(paths: Sequence[Path]) -> list[Case]:
    """All cases of files and folders, by name; a report that cannot be read is a case too.

    A folder with a ``summary.txt`` is a report. Any other folder holds reports, or files of the scenario language.

    Raises:
        InputError: a path does not exist or holds nothing of the kind, or two cases have one name.
    """
    cases: dict[str, Case] = {}
    for path in paths:
        for place in _places(path):
            case = _case(place)
            if case.name in cases:
                raise InputError(str(place), f"there are two cases {case.name!r}", "give each another name")
            cases[case.name] = case
    return [cases[name] for name in sorted(cases)]


def _places(path: Path) -> list[Path]:
    if path.is_file() or (path / _SUMMARY).is_file():
        return [path]
    if not path.is_dir():
        raise InputError(
            str(path), "no such file or folder", "give a report, a file of the scenario language or a folder"
        )
    found = [each for each in sorted(path.iterdir()) if (each / _SUMMARY).is_file() or each.suffix in _FILES]
    if not found:
        mend = f"give a folder with {_SUMMARY}, or with {', '.join(sorted(_FILES))} files"
        raise InputError(str(path), "holds neither reports nor files of the scenario language", mend)
    return found


def _case(place: Path) -> Case:
    folder = place if place.is_dir() else place.parent
    name = folder.resolve().name if place.is_dir() or place.stem in _GENERIC else place.stem
    sketch = next((each for each in sorted(folder.glob("sketch.*")) if each.is_file()), None)
    try:
        crash = _read_report(place) if place.is_dir() else load_crash_scenario(place)
    except RoadmendError as error:
        return Case(name, None, sketch, str(error))
    return Case(name, crash, sketch)


def _read_report(folder: Path) -> CrashScenario:
    path = folder / _SUMMARY
    try:
        summary = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(str(path), f"cannot be read ({error})", "give a readable UTF-8 text file") from None
    reading = read_summary(summary)
    if reading is None:
        raise InputError(str(path), "speaks of no vehicle", "give a crash report")
    return reading.scenario
