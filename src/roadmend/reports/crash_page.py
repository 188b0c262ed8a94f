"""A page by which a person can judge how a crash report was read: text, sketch, scene and run, and what is in doubt."""

import base64
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, Field

from roadmend.core.appearance import VEHICLE_COLOURS
from roadmend.core.errors import InputError, RoadmendError
from roadmend.core.extras import extra_missing
from roadmend.core.json_text import read_json
from roadmend.language.chat import Image
from roadmend.reports.crash_phrases import colour_of, family_of, phrases_of
from roadmend.reports.page import render
from roadmend.safe.cases import CrashCase
from roadmend.safe.dsl_data import dump_data
from roadmend.safe.extraction import Extraction
from roadmend.safe.report import CrashReport

_NOTHING: dict[str, Any] = {"value": None, "confidence": None, "reason": "", "span": None, "box": None, "doubts": ()}
_IN_DOUBT = 0.7  # a field below that is named among the doubts
SHOWN = ("image/png", "image/jpeg", "image/gif", "image/webp", "image/bmp")  # by every browser


class _KeptEvidence(BaseModel):
    """What the page takes of a field's evidence in a file that may have been altered."""

    model_config = ConfigDict(strict=True, allow_inf_nan=False)

    value: Any = None
    confidence: float | None = None
    reason: str = ""
    span: list[int] | None = Field(None, min_length=2, max_length=2)
    box: list[float] | None = Field(None, min_length=4, max_length=4)
    doubts: list[str] = Field(default_factory=list)


class _Kept(BaseModel):
    """What the page takes of CASE.evidence.json."""

    model_config = ConfigDict(strict=True)

    fields: dict[str, _KeptEvidence]
    sketch: str
    notes: list[str]


@dataclass(frozen=True, slots=True)
class CrashAccount:
    """All that a page tells of a report.

    Attributes:
        case: name of the report.
        summary: its text; empty where that is not at hand.
        sketch: its picture, where there is one.
        fields: what each field rests on, as CASE.evidence.json has them.
        sketch_note: whether the sketch was read.
        notes: what else is to be known.
        films: of the scenario as built, or of its runs, see ``crash_film``.
    """

    case: str
    summary: str
    sketch: Image | None
    fields: Mapping[str, Mapping[str, Any]]
    sketch_note: str
    notes: Sequence[str] = ()
    films: Sequence[Mapping[str, Any]] = ()


def page_of_crash(account: CrashAccount) -> str:
    """The text of the page; one file that needs nothing else."""
    rows = [_row(name, evidence) for name, evidence in account.fields.items()]
    families = dict.fromkeys(row["family"] for row in rows)
    return render(
        "crash.html",
        case=account.case,
        phrases=phrases_of(account.summary, account.fields),
        rows=rows,
        families=[(family, next(row["colour"] for row in rows if row["family"] == family)) for family in families],
        sketch=_sketch(account),
        sketch_note=account.sketch_note,
        doubts=list(_doubts(account.fields)),
        gaps=[row["name"] for row in rows if row["value"] == "" and row["name"] != "stem_direction"],
        notes=[note for note in account.notes if note.partition(" is in doubt")[0] not in account.fields],
        films=list(account.films),
        colours=VEHICLE_COLOURS,
    )


def account_of_case(case: CrashCase, films: Sequence[Mapping[str, Any]]) -> CrashAccount:
    """The account of a case that a command read; without its report there is nothing but the fields' values."""
    summary = case.report.summary if case.report is not None else ""
    if case.extraction is not None:
        return account_of_extraction(case.name, summary, case.sketch, case.extraction, films)
    note = "there is none" if case.sketch is None else "not read"
    fields = _stated(dump_data(case.crash)) if case.crash is not None else {}
    return CrashAccount(case.name, summary, case.sketch, fields, note, films=films)


def account_of_extraction(
    case: str, summary: str, sketch: Image | None, extraction: Extraction, films: Sequence[Mapping[str, Any]]
) -> CrashAccount:
    """The account of a report that was just read."""
    fields = {name: asdict(evidence) for name, evidence in extraction.evidence.items()}
    return CrashAccount(case, summary, sketch, fields, extraction.sketch, extraction.notes, films)


def load_account(report: CrashReport, out: Path, films: Sequence[Mapping[str, Any]]) -> CrashAccount:
    """The account of a report whose extraction lies in a folder.

    Raises:
        InputError: CASE.evidence.json is missing or broken.
    """
    path = out / f"{report.case}.evidence.json"
    try:
        kept = _Kept.model_validate(read_json(path))
        fields = {name: evidence.model_dump() for name, evidence in kept.fields.items()}
        return CrashAccount(report.case, report.summary, report.sketch, fields, kept.sketch, tuple(kept.notes), films)
    except ValueError:
        raise InputError(
            str(path), "is no evidence of an extraction", "delete it and extract the report anew"
        ) from None


def _stated(crash: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """The fields of a scenario that nobody read, but a file states."""
    stated = {name: crash.get(name) for name in ("road_type", "num_lanes", "stem_direction")}
    for index, vehicle in enumerate(crash["vehicles"]):
        stated |= {
            f"vehicles[{index}].{name}": vehicle.get(name)
            for name in ("model", "initial_position", "action", "speed_limit_mph")
        }
    stated |= {f"env.{name}": crash["env"].get(name) for name in ("time", "weather")}
    return {name: {**_NOTHING, "value": value, "reason": "the file states it"} for name, value in stated.items()}


def _row(name: str, evidence: Mapping[str, Any]) -> dict[str, Any]:
    """A line of the table of fields."""
    value, confidence = evidence["value"], evidence["confidence"]
    source = "summary" if evidence.get("span") else "sketch" if evidence.get("box") else "follows"
    return {
        "name": name,
        "family": family_of(name),
        "colour": colour_of(name),
        "value": "" if value is None else str(value),
        "confidence": None if confidence is None or value is None else float(confidence),
        "source": source if value is not None else "",
        "reason": evidence["reason"],
        "doubts": evidence.get("doubts") or (),
        "box": evidence.get("box"),
    }


def _doubts(fields: Mapping[str, Mapping[str, Any]]) -> Iterator[tuple[str, str]]:
    for name, evidence in fields.items():
        confidence = evidence["confidence"]
        if evidence["value"] is not None and confidence is not None and confidence < _IN_DOUBT:
            yield name, f"{evidence['value']} with confidence {confidence:.2f} only"
        for doubt in evidence.get("doubts") or ():
            yield name, doubt


def _sketch(account: CrashAccount) -> dict[str, Any] | None:
    """The sketch with what was read drawn over it, or bare; and the boxes of the fields that rest on it."""
    if account.sketch is None:
        return None
    data, media_type = account.sketch.data, account.sketch.media_type
    drawn = _drawn_over(account.sketch)
    if drawn is not None:
        data, media_type = drawn, "image/png"
    elif media_type not in SHOWN:
        return None
    return {"data": base64.b64encode(data).decode("ascii"), "type": media_type, "is_read": drawn is not None}


def _drawn_over(sketch: Image) -> bytes | None:
    try:
        from roadmend.safe.sketch.drawing import drawn_over  # noqa: PLC0415 - an extra that may be missing
        from roadmend.safe.sketch.reading import read_sketch  # noqa: PLC0415
    except ModuleNotFoundError as error:
        extra_missing(error)
        return None
    try:
        return drawn_over(read_sketch(sketch))
    except RoadmendError:
        return None
