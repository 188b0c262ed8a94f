"""How much of what reports say an extraction has read right, against readings by people (SAFE, table 4)."""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from roadmend.core.errors import InputError
from roadmend.safe.cases import CrashCase
from roadmend.safe.dsl import RoadType
from roadmend.safe.dsl_data import dump_data

ORACLE = "oracle.json"
CATEGORIES = ("road", "actors", "env")
_ROAD = ("road_type", "num_lanes", "stem_direction")
_VEHICLE = ("model", "initial_position", "action", "speed_limit_mph")
_ENV = ("time", "weather")


@dataclass(frozen=True, slots=True)
class Scores:
    """Shares of cases [%] in which every field of a category is right; ``overall`` asks for all three."""

    cases: int
    road: float
    actors: float
    env: float
    overall: float


def score_cases(cases: Sequence[CrashCase], folder: Path, *, text_only: bool) -> Scores | None:
    """Score the cases that have an oracle, FOLDER/NAME/oracle.json; None if none has.

    An oracle's field that is null is not counted, except a stem where there is none. ``alternatives`` are right too.
    A case that could not be read is wrong everywhere.

    Args:
        cases: as they were read.
        folder: of the reports.
        text_only: use the oracle's ``text_only_overrides``, which say what the summary tells without the sketch.

    Raises:
        InputError: an oracle is damaged.
    """
    marks = [
        _mark(case, _read(path), text_only=text_only)
        for case in cases
        if (path := folder / case.name / ORACLE).is_file()
    ]
    if not marks:
        return None

    def share(names: Sequence[str]) -> float:
        return round(100.0 * sum(all(mark[name] for name in names) for mark in marks) / len(marks), 1)

    return Scores(len(marks), share(["road"]), share(["actors"]), share(["env"]), share(CATEGORIES))


def _read(path: Path) -> dict[str, Any]:
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        fields = dict(_fields(content))
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        raise InputError(str(path), "is no oracle", "give the fields of the scenario language as JSON") from None
    if all(value is None for value in fields.values()):
        raise InputError(str(path), "names no field of the scenario language", "give its fields as JSON")
    return dict(content)


def _mark(case: CrashCase, oracle: Mapping[str, Any], *, text_only: bool) -> dict[str, bool]:
    """Whether each category of one case is right throughout."""
    if case.crash is None:
        return dict.fromkeys(CATEGORIES, False)
    wanted = dict(_fields(oracle)) | (oracle.get("text_only_overrides") or {} if text_only else {})
    found = dict(_fields(dump_data(case.crash)))
    alternatives = oracle.get("alternatives") or {}
    marks = dict.fromkeys(CATEGORIES, True)
    marks["actors"] = len(case.crash.vehicles) == len(oracle["vehicles"])
    for field, value in wanted.items():
        got = found.get(field)
        if value is None:
            is_right = field != "stem_direction" or oracle.get("road_type") == RoadType.T_INTERSECTION or got is None
        else:
            is_right = got in (value, *alternatives.get(field, ()))
        marks[_category(field)] &= is_right
    return marks


def _category(field: str) -> str:
    return "actors" if field.startswith("vehicles") else "env" if field.startswith("env") else "road"


def _fields(content: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    yield from ((name, content.get(name)) for name in _ROAD)
    for index, vehicle in enumerate(content["vehicles"]):
        yield from ((f"vehicles[{index}].{name}", vehicle.get(name)) for name in _VEHICLE)
    yield from ((f"env.{name}", content["env"].get(name)) for name in _ENV)
