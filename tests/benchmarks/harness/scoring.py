"""How much of what reports say an extraction has read right, field by field, against oracles (SAFE, table 4)."""

import itertools
import json
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from roadmend.core.errors import InputError
from roadmend.safe.dsl import RoadType

ORACLE = "oracle.json"
CATEGORIES = ("road", "actors", "env")
BINS = (0.0, 0.5, 0.7, 0.8, 0.9, 1.0)  # of confidence; the last one holds 1 too
_ROAD = ("road_type", "num_lanes", "stem_direction")
_VEHICLE = ("model", "initial_position", "action", "speed_limit_mph")
_ENV = ("time", "weather")
_COUNT = "vehicles.count"
_NOT_APPLICABLE = (None, "", "n/a", "not applicable")

Oracle = Mapping[str, Any]
Reading = Mapping[str, Any] | None  # plain data of the scenario language; None if a report could not be read


@dataclass(frozen=True, slots=True)
class Scores:
    """Shares of cases [%] in which every field of a category is right; ``overall`` asks for all three."""

    cases: int
    road: float
    actors: float
    env: float
    overall: float


def score(readings: Mapping[str, Reading], oracles: Mapping[str, Oracle], *, text_only: bool) -> Scores | None:
    """Score all cases that have an oracle and are among the readings; None if none has.

    Args:
        readings: what was read, by case.
        oracles: what is right, by case.
        text_only: use the oracles' ``text_only_overrides``, which say what the summary tells without the sketch.
    """
    right = [
        dict.fromkeys(CATEGORIES, False)
        if readings[case] is None
        else by_category(mark(readings[case], oracles[case], text_only=text_only))
        for case in sorted({*readings} & {*oracles})
    ]
    if not right:
        return None

    def share(names: Sequence[str]) -> float:
        return round(100.0 * sum(all(each[name] for name in names) for each in right) / len(right), 1)

    return Scores(len(right), share(["road"]), share(["actors"]), share(["env"]), share(CATEGORIES))


def mark(reading: Reading, oracle: Oracle, *, text_only: bool) -> dict[str, bool]:
    """Whether each field of one case that can be decided is right, and the number of vehicles.

    An oracle's field that is null is not asked, except a stem where there is none. ``alternatives`` are right too. A
    case that could not be read is wrong everywhere.
    """
    wanted = dict(_fields(oracle)) | (oracle.get("text_only_overrides") or {} if text_only else {})
    found = {} if reading is None else dict(_fields(reading))
    alternatives = oracle.get("alternatives") or {}
    marks = {_COUNT: reading is not None and len(reading["vehicles"]) == len(oracle["vehicles"])}
    for field, value in wanted.items():
        got = found.get(field)
        if value is not None:
            allowed = [_plain(each) for each in (value, *alternatives.get(field, ()))]
            marks[field] = _plain(got) in allowed
        elif field == "stem_direction" and oracle["road_type"] != RoadType.T_INTERSECTION:
            marks[field] = reading is not None and _plain(got) in _NOT_APPLICABLE
    return marks


def filled(reading: Reading, oracle: Oracle) -> list[bool]:
    """Of each field that the oracle leaves open, but for stems and what it has ``alternatives`` for, whether the reading gives it."""
    found = {} if reading is None else dict(_fields(reading))
    others = {"stem_direction", *(oracle.get("alternatives") or ())}
    open_ = (name for name, value in _fields(oracle) if value is None and name not in others)
    return [_plain(found.get(name)) not in _NOT_APPLICABLE for name in open_]


def by_category(marks: Mapping[str, bool]) -> dict[str, bool]:
    """Whether each category of a case is right throughout."""
    right = dict.fromkeys(CATEGORIES, True)
    for field, is_right in marks.items():
        right[_category(field)] &= is_right
    return right


@dataclass(frozen=True, slots=True)
class Bin:
    """Fields of one range of confidence: how many, and the share that is right."""

    low: float
    high: float
    count: int
    right: float | None
    confidence: float | None  # mean


def calibrate(marked: Sequence[tuple[float, bool]]) -> list[Bin]:
    """A reliability table of fields, each with its confidence and whether it is right."""
    table = []
    for low, high in itertools.pairwise(BINS):
        own = [(sure, right) for sure, right in marked if low <= sure < high or (sure == high == BINS[-1])]
        count = len(own)
        table.append(
            Bin(
                low,
                high,
                count,
                round(sum(right for _, right in own) / count, 3) if count else None,
                round(sum(sure for sure, _ in own) / count, 3) if count else None,
            )
        )
    return table


def majority(oracles: Sequence[Oracle]) -> dict[str, Any]:
    """The trivial reader: of each field the value that most of the given oracles have, for as many vehicles as usual."""
    counts: dict[str, Counter[Any]] = {}
    for oracle in oracles:
        for field, value in _fields(oracle):
            counts.setdefault(field.rpartition("].")[2], Counter())[value] += value is not None
    usual = {field: _most(counter) for field, counter in counts.items()}
    vehicles = _most(Counter(len(oracle["vehicles"]) for oracle in oracles))
    if usual["road_type"] != RoadType.T_INTERSECTION:
        usual["stem_direction"] = None
    return {name: usual[name] for name in _ROAD} | {
        "vehicles": [{name: usual[name] for name in _VEHICLE}] * vehicles,
        "env": {name: usual[f"env.{name}"] for name in _ENV},
    }


def _most(counter: Counter[Any]) -> Any:
    return max(counter, key=lambda value: (counter[value], str(value)))


def load_oracles(folder: Path) -> dict[str, Oracle]:
    """The oracles of reports, FOLDER/CASE/oracle.json or FOLDER/CASE.oracle.json, by case.

    Raises:
        InputError: one is damaged.
    """
    files = {path.parent.name: path for path in sorted(folder.glob(f"*/{ORACLE}"))}
    files |= {path.name.removesuffix(f".{ORACLE}"): path for path in sorted(folder.glob(f"*.{ORACLE}"))}
    return {case: _read(path) for case, path in files.items()}


def oracles_of_records(folder: Path) -> dict[str, Oracle]:
    """The oracles that records of crashes carry, by case.

    Raises:
        InputError: one is damaged.
    """
    found = {}
    for path in sorted(folder.glob("*.json")):
        oracle = _json(path).get("oracle")
        if oracle is not None:
            found[path.stem] = _checked(oracle, path)
    return found


def _read(path: Path) -> Oracle:
    return _checked(_json(path), path)


def _json(path: Path) -> dict[str, Any]:
    try:
        return dict(json.loads(path.read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError):
        raise InputError(str(path), "is no oracle", "give the fields of the scenario language as JSON") from None


def _checked(content: Any, path: Path) -> Oracle:
    try:
        fields = dict(_fields(content))
    except (KeyError, TypeError, AttributeError):
        raise InputError(str(path), "is no oracle", "give the fields of the scenario language as JSON") from None
    if all(value is None for value in fields.values()):
        raise InputError(str(path), "names no field of the scenario language", "give its fields as JSON")
    return dict(content)


def _plain(value: Any) -> Any:
    return value.strip().lower() if isinstance(value, str) else value


def _category(field: str) -> str:
    return "actors" if field.startswith("vehicles") else "env" if field.startswith("env") else "road"


def _fields(content: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    yield from ((name, content.get(name)) for name in _ROAD)
    for index, vehicle in enumerate(content["vehicles"]):
        yield from ((f"vehicles[{index}].{name}", vehicle.get(name)) for name in _VEHICLE)
    yield from ((f"env.{name}", content["env"].get(name)) for name in _ENV)
