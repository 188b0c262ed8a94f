"""Crash reports on disk: a folder with a summary and perhaps a sketch, or a text file alone."""

import codecs
import hashlib
import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import PIL.Image

from roadmend.core.bounded_file import opened, read_bytes
from roadmend.core.bounds import SKETCH
from roadmend.core.errors import InputError
from roadmend.language.chat import Image
from roadmend.safe.picture_file import UNREADABLE, open_picture_file

MAX_SUMMARY = 60_000  # [characters] the longest report of NHTSA that we know has 6000
_SKETCHES = (".jpg", ".jpeg", ".png", ".gif", ".webp", ".bmp", ".tif", ".tiff")
_NAME_BYTES = 200  # of a report's name, so that with the ending of any file it stays below the 255 that there may be
_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.\-]{0,99}")
_CONTROL = re.compile(r"[\x00-\x08\x0e-\x1f\x7f]")


@dataclass(frozen=True, slots=True)
class CrashReport:
    """What an extraction starts from.

    Attributes:
        case: name of the report.
        summary: its text.
        sketch: None where there is none that can be opened.
        notes: what is to be said of the files.
    """

    case: str
    summary: str
    sketch: Image | None = None
    notes: tuple[str, ...] = ()

    def digest(self) -> str:
        """The same for the same summary and sketch."""
        value = hashlib.sha256(self.summary.encode())
        value.update(b"\0" + (self.sketch.data if self.sketch is not None else b""))
        return value.hexdigest()


LANGUAGE_SUFFIXES = {".json", ".yaml", ".yml"}  # of files of the scenario language
EVIDENCE = ".evidence"  # stands in the name of what 'roadmend safe extract' writes beside a scenario


@contextmanager
def looking_through() -> Iterator[None]:
    """While folders are looked through: what the system refuses becomes one line.

    Raises:
        InputError: there is one of which the user may not see what it holds.
    """
    try:
        yield
    except OSError as error:
        what = f"cannot be read ({error.strerror})"
        raise InputError(str(error.filename), what, "make it readable, or move it elsewhere") from None


def find_reports(*paths: Path) -> tuple[Path, ...]:
    """The reports at some paths: each itself, or what a folder of reports holds.

    Raises:
        InputError: there is none at one of them, a folder cannot be read, or two have one name, which files go by, or
            one that belongs to the files of another.
    """
    with looking_through():
        reports = tuple(report for path in paths for report in _reports_at(path))
    seen: dict[str, Path] = {}
    for report in reports:
        name = case_of(report)
        if name.endswith(EVIDENCE):
            what = f"has a name that ends in {EVIDENCE}, as files do that say what a reading rests on"
            raise InputError(str(report), what, "rename it")
        if name in seen:
            raise InputError(str(report), f"has the name of {seen[name]}", "rename one of them")
        seen[name] = report
    return reports


def _reports_at(path: Path) -> tuple[Path, ...]:
    if path.is_file() and path.suffix.lower() in LANGUAGE_SUFFIXES:
        raise InputError(
            str(path), "is no text but a file of data", "a scenario is for 'safe build', 'test' and 'reproduce'"
        )
    if path.is_file() or (path.is_dir() and _summary_of(path) is not None):
        return (path,)
    if not path.is_dir():
        raise InputError(
            str(path), "no such report or folder", "give a text file, a report's folder, or a folder of those"
        )
    entries = sorted(entry for entry in path.iterdir() if not entry.name.startswith("."))
    reports = tuple(
        entry
        for entry in entries
        if (entry.is_dir() and _summary_of(entry) is not None) or entry.suffix.lower() == ".txt"
    )
    if not reports:
        raise InputError(str(path), "holds no report", "a report is a .txt file, or a folder with summary.txt in it")
    return reports


def case_of(path: Path) -> str:
    """The name of the report at a path."""
    return path.stem if path.is_file() else path.resolve().name


def _summary_of(folder: Path) -> Path | None:
    texts = [entry for entry in sorted(folder.iterdir()) if entry.is_file() and entry.name.lower() == "summary.txt"]
    return texts[0] if texts else None


def load_report(path: Path) -> CrashReport:
    """Read one report.

    Raises:
        InputError: the summary is missing, empty, too long, or no text, the name is too long for the files that go by
            it, or the folder cannot be read.
    """
    if len(os.fsencode(case_of(path))) > _NAME_BYTES:
        raise InputError(str(path), f"has a name of more than {_NAME_BYTES} bytes", "rename it: files are called by it")
    with looking_through():
        summary = path if path.is_file() else _summary_of(path)
    if summary is None:
        raise InputError(str(path), "has no summary", "put the text of the report into summary.txt")
    text = _read_text(summary)
    if path.is_file():
        return CrashReport(case_of(path), text)
    sketch, notes = _read_sketch(path)
    return CrashReport(case_of(path), text, sketch, notes)


def report_of_text(case: str, summary: str) -> CrashReport:
    """A report that is no file.

    Args:
        case: its name; files are called by it.
        summary: its text.

    Raises:
        InputError: the name cannot be a file's, or the summary is empty, too long, or no text.
    """
    if not _NAME.fullmatch(case) or case.endswith(EVIDENCE):
        mend = f"use letters, digits, '.', '_' and '-', and do not end in {EVIDENCE}"
        raise InputError(f"name {case[:60]!r}", "cannot be a file's", mend)
    return CrashReport(case, _checked(summary, "the summary"), None, ("the report has no sketch",))


def _read_text(path: Path) -> str:
    with opened(path, "give a readable text file") as file:
        data = file.read(4 * MAX_SUMMARY + 4)
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):  # as Windows' editor saves "Unicode"
        return _checked(data.decode("utf-16", errors="replace"), str(path))
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        if error.start >= 4 * MAX_SUMMARY:  # cut within a character
            text = data[: error.start].decode("utf-8-sig")
        else:
            text = data.decode("cp1252", errors="replace")  # what NHTSA's older exports are in
    return _checked(text, str(path))


def _checked(text: str, where: str) -> str:
    if _CONTROL.search(text) or text.count("\ufffd") > len(text) // 100:
        raise InputError(where, "is no text", "give the summary as plain text")
    if len(text) > MAX_SUMMARY:
        raise InputError(where, f"is longer than {MAX_SUMMARY} characters", "give the summary of one crash alone")
    if not text.strip():
        raise InputError(where, "is empty", "put the summary of the crash into it")
    return text


def _read_sketch(folder: Path) -> tuple[Image | None, tuple[str, ...]]:
    files = [
        entry
        for entry in sorted(folder.iterdir())
        if entry.stem.lower() == "sketch" and entry.suffix.lower() in _SKETCHES
    ]
    if not files:
        return None, ("the report has no sketch",)
    file = files[0]
    try:
        data = read_bytes(file, SKETCH, "give an image")
    except InputError as error:
        return None, (f"{file.name} {error.what} and was left out",)
    try:
        with open_picture_file(data) as image:
            media_type = PIL.Image.MIME[image.format or ""]
            is_large = image.width * image.height > SKETCH.values
            image.verify()
    except UNREADABLE:
        return None, (f"{file.name} is no image that can be opened and was left out",)
    if is_large:
        return None, (f"{file.name} has more than {SKETCH.values // 1_000_000} million pixels and was left out",)
    return Image(data, media_type), ()
