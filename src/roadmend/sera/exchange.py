"""Banks as JSON lines: a header, then one entry a line."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from roadmend.core.bounded_file import read_lines
from roadmend.core.bounds import STREAM
from roadmend.core.errors import InputError
from roadmend.core.json_text import parse_json
from roadmend.core.settings import describe
from roadmend.core.whole_file import written_beside
from roadmend.sera.bank import Bank
from roadmend.sera.bank_file import DESCRIPTOR
from roadmend.sera.descriptor import BankEntry, Descriptor
from roadmend.world.scenario_file import parse_scenario

FORMAT = "roadmend-bank-export/1"
_KEYS = {"digest", "name", "origin", "descriptor", "scenario"}


def export_bank(bank: Bank, path: Path) -> None:
    """Write all entries, complete or not at all.

    Raises:
        InputError: the place cannot be written, or the bank is damaged.
    """
    with written_beside(path) as beside, beside.open("w", encoding="utf-8") as file:
        file.write(json.dumps({"format": FORMAT, "entries": len(bank)}) + "\n")
        file.writelines(_dump(entry) for entry in bank.entries())


def read_export(path: Path) -> Iterator[BankEntry]:
    """The entries of an export, one at a time.

    Raises:
        InputError: the file is missing, is no export, is cut short, or a line is at fault.
    """
    remedy = "give a file that 'roadmend sera bank export' made"
    lines = read_lines(path, STREAM, remedy)
    wanted = _parse_header(path, next(lines, ""), remedy)
    found = 0
    for found, line in enumerate(lines, 1):
        yield _parse(f"{path} line {found + 1}", line)
    if found != wanted:
        raise InputError(str(path), f"holds {found} of {wanted} entries", "export the bank again")


def _dump(entry: BankEntry) -> str:
    content = {
        "digest": entry.digest,
        "name": entry.name,
        "origin": entry.origin,
        "descriptor": DESCRIPTOR.dump_python(entry.descriptor, mode="json", exclude_defaults=True),
        "scenario": None if entry.scenario is None else entry.scenario.model_dump(mode="json"),
    }
    return json.dumps(content, separators=(",", ":"), allow_nan=False) + "\n"


def _parse_header(path: Path, line: str, remedy: str) -> int:
    try:
        header: Any = parse_json(line, str(path), STREAM)
        form, entries = header["format"], int(header["entries"])
    except (InputError, ValueError, KeyError, TypeError, OverflowError):
        raise InputError(str(path), "is no export of a bank", remedy) from None
    if form != FORMAT:
        raise InputError(str(path), f"has the format {form!r}, not {FORMAT!r}", remedy)
    return entries


def _parse(where: str, line: str) -> BankEntry:
    remedy = "mend the line, or export the bank again"
    content = parse_json(line, where, STREAM, remedy, is_line=True)
    if not isinstance(content, dict) or content.keys() != _KEYS:
        raise InputError(where, f"has other fields than {', '.join(sorted(_KEYS))}", remedy)
    try:
        descriptor = DESCRIPTOR.validate_python(content["descriptor"], strict=False)
    except ValidationError as error:
        raise InputError(where, describe(error, Descriptor), remedy) from None
    scenario = None if content["scenario"] is None else parse_scenario(content["scenario"], where)
    if scenario is not None and scenario.digest != content["digest"]:
        raise InputError(where, "has another digest than its scenario", remedy)
    return BankEntry(str(content["digest"]), str(content["name"]), str(content["origin"]), descriptor, scenario)
