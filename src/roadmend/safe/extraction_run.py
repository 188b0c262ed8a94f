"""Extraction of many reports: side by side, and resumable."""

import contextlib
import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from roadmend.core.errors import ForeignError, InputError, RoadmendError
from roadmend.core.journal import entry_key
from roadmend.core.json_text import read_json
from roadmend.core.whole_file import write_text, write_texts
from roadmend.language.exchange import ENDING, Usage, dump_exchanges, usage_of
from roadmend.safe.dsl_data import dump_data
from roadmend.safe.dsl_file import dump_crash_scenario, load_crash_scenario
from roadmend.safe.extraction import Extraction, ExtractionError, Extractor
from roadmend.safe.report import case_of, load_report


@dataclass(frozen=True, slots=True)
class Extracted:
    """What became of one report.

    Attributes:
        case: its name.
        scenario: plain data; None where none came out.
        error: why, then.
        open_fields: names of the fields that the report leaves open.
        is_new: False where an earlier run had done it.
        disputed_fields: names of those of which sources say different things.
        usage: what this run took for it, by model.
    """

    case: str
    scenario: dict[str, Any] | None
    error: str | None
    open_fields: tuple[str, ...]
    is_new: bool
    disputed_fields: tuple[str, ...] = ()
    usage: Mapping[str, Usage] = field(default_factory=dict)


def extract_reports(
    paths: Sequence[Path], extractor: Extractor, settings: Sequence[str], out: Path, workers: int
) -> Iterator[Extracted]:
    """Extract reports; each result is written before it is given, in the order in which they are done.

    CASE.json is the scenario, CASE.evidence.json what each field rests on, CASE.exchanges.jsonl what was said to a
    language model and what it answered. A report whose files are there from an earlier run with the same settings is
    not done again; one that failed is. A CASE.json that no call wrote, or that was changed since, is somebody's work: it
    stays, and its report is not done.

    Args:
        paths: of the reports.
        extractor: reads them; called from several threads.
        settings: what decides the result beside the report and the code.
        out: folder to write to.
        workers: threads.

    Raises:
        InputError: the folder cannot be written, or the extractor lacks something that every report needs.
    """
    with ThreadPoolExecutor(workers) as pool:
        tasks = [pool.submit(_extract_one, path, extractor, settings, out) for path in paths]
        try:
            for task in as_completed(tasks):
                yield task.result()
        finally:
            for task in tasks:
                task.cancel()


def _extract_one(path: Path, extractor: Extractor, settings: Sequence[str], out: Path) -> Extracted:
    case = case_of(path)
    try:
        report = load_report(path)
    except InputError as error:
        _remove_results(out, case)
        return Extracted(case, None, str(error), (), is_new=True)
    key = entry_key([__name__, type(extractor).__module__], report.digest(), *settings)
    try:
        check_own(out, case, str(path))
    except InputError as error:
        return Extracted(case, None, str(error), (), is_new=True)
    known = _known(out, case, key)
    if known is not None:
        return known
    _remove_results(out, case)
    try:
        extraction = extractor.extract(report)
    except ExtractionError as error:
        if error.exchanges:
            write_text(out / f"{case}{ENDING}", dump_exchanges(error.exchanges))
        return Extracted(case, None, f"{path}: {error}", (), is_new=True, usage=usage_of(error.exchanges))
    except ForeignError as error:  # a backend of the user's own may well answer about the other reports
        return Extracted(case, None, f"{path}: {error}", (), is_new=True)
    return keep_extraction(extraction, case, key, out)


def check_own(out: Path, case: str, source: str) -> None:
    """Check that a report may be kept in a folder: that it would take the place of no work but that of an earlier call.

    Args:
        out: the folder.
        case: name of the report.
        source: what the message calls it.

    Raises:
        InputError: its CASE.json was changed since it was read, or is somebody else's.
    """
    if not _is_somebodys(out, case):
        return
    what = f"is no longer what was read from {source}"
    if _evidence_of(out, case) is None:
        what = f"is there, and was not read from {source}"
    raise InputError(str(out / f"{case}.json"), what, "move it elsewhere, or delete it to have the report read anew")


def _remove_results(out: Path, case: str) -> None:
    """Take away what an earlier call read, with other settings or of another text: what fails now shall not leave it.

    Files of these names that no call wrote stay, and so does a scenario that was changed since.
    """
    if _evidence_of(out, case) is None or _is_somebodys(out, case):
        return
    for ending in (".html", ".json", ".evidence.json"):  # the last one says whose the others are
        with contextlib.suppress(OSError):  # who writes there next says what is wrong with the folder
            (out / f"{case}{ending}").unlink()


def _evidence_of(out: Path, case: str) -> dict[str, Any] | None:
    """What an earlier call kept of the case; None where there is nothing of the kind."""
    try:
        evidence = read_json(out / f"{case}.evidence.json")
    except InputError:
        return None
    return evidence if isinstance(evidence, dict) and "key" in evidence else None


def _is_somebodys(out: Path, case: str) -> bool:
    """Whether there is a scenario that is another one than was read, readable or not."""
    file = out / f"{case}.json"
    # In this order: another process that keeps the same report puts the evidence there before the scenario.
    if not file.is_file():
        return False
    evidence = _evidence_of(out, case)
    if evidence is not None and "scenario" not in evidence:
        return False
    try:
        text = dump_crash_scenario(load_crash_scenario(file), ".json")
    except InputError:
        return file.is_file()
    return evidence is None or bool(_digest(text) != evidence["scenario"])


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def _known(out: Path, case: str, key: str) -> Extracted | None:
    try:
        evidence = _evidence_of(out, case)
        if evidence is None or evidence["key"] != key:
            return None
        scenario = load_crash_scenario(out / f"{case}.json")
        left_open, disputed = _open_fields(evidence["fields"]), _disputed_fields(evidence["fields"])
    except (OSError, ValueError, KeyError, TypeError, RoadmendError):
        return None  # done again, then
    return Extracted(case, dump_data(scenario), None, left_open, is_new=False, disputed_fields=disputed)


def keep_extraction(extraction: Extraction, case: str, key: str, out: Path) -> Extracted:
    """Write the files of one extraction, as :func:`extract_reports` describes them, in the place of an earlier call's.

    Args:
        extraction: of the report.
        case: the report's name.
        key: by which a later run tells whether this is what it would do.
        out: folder to write to.

    Raises:
        InputError: the folder cannot be written.
    """
    fields = {name: asdict(evidence) for name, evidence in extraction.evidence.items()}
    text = dump_crash_scenario(extraction.scenario, ".json")
    content = {
        "key": key,
        "scenario": _digest(text),
        "reader": extraction.reader,
        "sketch": extraction.sketch,
        "notes": extraction.notes,
        "fields": fields,
    }
    if extraction.exchanges:
        write_text(out / f"{case}{ENDING}", dump_exchanges(extraction.exchanges))
    _remove_results(out, case)
    # The scenario takes its place last: one without evidence is somebody else's, and evidence alone is done again.
    evidence = json.dumps(content, indent=1, ensure_ascii=False) + "\n"
    write_texts(out, {f"{case}.json": text, f"{case}.evidence.json": evidence})
    scenario = dump_data(extraction.scenario)
    usage = usage_of(extraction.exchanges)
    return Extracted(
        case,
        scenario,
        None,
        _open_fields(fields),
        is_new=True,
        disputed_fields=_disputed_fields(fields),
        usage=usage,
    )


def _open_fields(fields: Mapping[str, Any]) -> tuple[str, ...]:
    return tuple(name for name, evidence in fields.items() if evidence["value"] is None and name != "stem_direction")


def _disputed_fields(fields: Mapping[str, Any]) -> tuple[str, ...]:
    return tuple(name for name, evidence in fields.items() if evidence.get("disputed"))
