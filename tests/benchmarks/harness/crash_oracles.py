"""Reports with what a person says they say, from several places and in several forms."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from harness.liar import put
from roadmend.core.errors import InputError
from roadmend.core.resources import config_folder
from roadmend.safe.dsl import CrashScenario
from roadmend.safe.dsl_data import parse_data
from roadmend.safe.report import CrashReport, load_report

_SAMPLES = Path(__file__).parents[1] / "sample_oracles"
_KNOWN = ("road_type", "num_lanes", "stem_direction", "vehicles", "env", "collisions")
_OF_VEHICLE = ("model", "initial_position", "action", "speed_limit_mph", "manoeuvre")


@dataclass(frozen=True, slots=True)
class KnownReport:
    """A report and the truth about it.

    Attributes:
        report: without its sketch.
        truth: what its text says; open where it says nothing.
        others: by field, further values that are right as well.
        knows: the parts of the language that the truth is told in; of others it says neither that they are open.
    """

    report: CrashReport
    truth: CrashScenario
    others: Mapping[str, Sequence[Any]] = field(default_factory=dict)
    knows: frozenset[str] = frozenset(_KNOWN)


def sample_reports() -> list[KnownReport]:
    """Those of config/reports."""
    folder = config_folder() / "reports"
    return [_known(load_report(folder / path.stem), path) for path in sorted(_SAMPLES.glob("*.json"))]


def reports_in(folder: Path, pattern: str = "*") -> list[KnownReport]:
    """Texts with an oracle beside them (NAME.txt, NAME.oracle.json), or folders with summary.txt and oracle.json.

    Args:
        folder: where they are.
        pattern: of the names.

    Raises:
        InputError: there is none, or an oracle is damaged.
    """
    found = [
        _known(load_report(path), path.with_suffix(".oracle.json"))
        for path in sorted(folder.glob(f"{pattern}.txt"))
        if path.with_suffix(".oracle.json").is_file()
    ]
    found += [_known(load_report(path.parent), path) for path in sorted(folder.glob(f"{pattern}/oracle.json"))]
    if not found:
        raise InputError(str(folder), "holds no report with an oracle", "put NAME.oracle.json beside NAME.txt")
    return found


def _known(report: CrashReport, path: Path) -> KnownReport:
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        data = {name: content[name] for name in _KNOWN if name in content}
        data["vehicles"] = [
            {name: vehicle[name] for name in _OF_VEHICLE if name in vehicle} for vehicle in data["vehicles"]
        ]
        for collision in data.get("collisions") or []:
            for name in ("striking_side", "struck_side"):
                side = collision.get(name)
                collision[name] = side.title() if side else None
        data["collisions"] = data.get("collisions") or []
        for name, value in (content.get("text_only_overrides") or {}).items():
            put(data, name, value)
        truth = parse_data(data, str(path))
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise InputError(str(path), f"is no oracle: {error}", "give the scenario language as JSON") from None
    # The summary alone: what a sketch shows no text can be held against.
    report = CrashReport(report.case, report.summary)
    return KnownReport(report, truth, content.get("alternatives") or {}, frozenset(content) & frozenset(_KNOWN))
