"""Records of real crashes: what is known of a crash apart from any reading of its report by a program.

A record is a file CASE.json that a person wrote (or the coded fields of an investigation gave). It says who ran into
whom, with which part, coming from and going to where, and on which road::

    {"case": "...", "crash": {"road": "Intersection",
      "vehicles": [{"number": 1, "from": "N", "to": "W", "manoeuvre": "turn left"}, ...],
      "collisions": [{"striking": 2, "struck": 1, "striking_part": "front", "struck_part": "left"}, ...],
      "doubt": []}, "annotator": "..."}

A record may also carry the scenario that a careful reader takes from the report, as ``oracle``; of it, the judge goes by
the alternatives of the road's type alone. ``from`` is the direction of travel before the crash and ``to`` the one that the vehicle meant to take, as points of the
compass. What is null is not known, and not asked of anybody.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from roadmend.core.bounds import CRASH
from roadmend.core.errors import InputError
from roadmend.core.json_text import read_json
from roadmend.safe.contact import Part

ROADS = ("Straight", "Curve", "Intersection", "T-intersection", "Merging")
HEADINGS: dict[str, float] = {  # [deg] counter-clockwise from east
    name: 45.0 * place for place, name in enumerate(("E", "NE", "N", "NW", "W", "SW", "S", "SE"))
}
_WORDS = {"north": "N", "south": "S", "east": "E", "west": "W"}
_FACES = {"front": "front", "rear": "rear", "back": "rear", "left": "left", "right": "right"}
_SILENT = {"side", "corner", "of", "the", "plane", "bumper", "end", "door", "fender", "quarter", "panel", "wheel"}
_UNKNOWN = {"unknown", "none", "unclear", "top", "undercarriage", "roof", ""}
_MEND = "see src/doc on crash records"


@dataclass(frozen=True, slots=True)
class RecordedVehicle:
    """What is known of one vehicle.

    Attributes:
        number: the report's, from 1.
        origin: heading before the crash [deg], counter-clockwise from east; None where it is not known.
        destination: heading that it was going to have [deg]; None where it is not known.
        manoeuvre: in words, lower case, perhaps empty.
    """

    number: int
    origin: float | None
    destination: float | None
    manoeuvre: str = ""

    @property
    def stands(self) -> bool:
        """Whether it stood when it was hit: stopped or parked."""
        return bool(re.search(r"\b(stop|stopped|parked|standing|stationary)\b", self.manoeuvre))

    @property
    def reverses(self) -> bool:
        """Whether it went backwards."""
        return bool(re.search(r"\b(revers\w*|back(ing|ed|s)?)\b", self.manoeuvre))


@dataclass(frozen=True, slots=True)
class RecordedCollision:
    """Two vehicles of the record come to touch, by number, with the parts as far as they are known."""

    striking: int
    struck: int
    striking_part: Part | None = None
    struck_part: Part | None = None


@dataclass(frozen=True, slots=True)
class CrashRecord:
    """What is known of a crash.

    Attributes:
        case: name of its report.
        roads: types of road that describe the place of the first collision; empty where none is known.
        stem: side of a T-intersection's stem, seen from its middle [deg]; None where it is not known.
        vehicles: those that are known.
        collisions: between two vehicles, in order; those with objects and people are not among them.
        events: collisions of all kinds that the record names.
    """

    case: str
    roads: tuple[str, ...]
    vehicles: tuple[RecordedVehicle, ...]
    collisions: tuple[RecordedCollision, ...]
    stem: float | None = None
    events: int = 0

    def vehicle(self, number: int) -> RecordedVehicle:
        """One vehicle by its number; one of which nothing is known if the record does not list it."""
        return next((each for each in self.vehicles if each.number == number), RecordedVehicle(number, None, None))


def load_records(folder: Path) -> dict[str, CrashRecord]:
    """All records of a folder, by case.

    Raises:
        InputError: it holds none, or one of them is broken.
    """
    files = sorted(folder.glob("*.json")) if folder.is_dir() else []
    if not files:
        raise InputError(str(folder), "holds no crash records", "give a folder with CASE.json files")
    return {file.stem: load_record(file) for file in files}


def load_record(path: Path) -> CrashRecord:
    """One record.

    Raises:
        InputError: names the file and the field.
    """
    content = read_json(path, CRASH, _MEND)
    return _Reader(str(path)).record(content, path.stem)


class _Reader:
    """Walks through a record; knows where it is."""

    def __init__(self, where: str) -> None:
        self._where = where

    def _fail(self, field: str, problem: str) -> InputError:
        return InputError(self._where, f"field {field}: {problem}", _MEND)

    def _mapping(self, content: object, field: str) -> Mapping[str, Any]:
        if not isinstance(content, Mapping):
            raise self._fail(field, f"is {content!r:.40}, not fields with values")
        return content

    def _list(self, content: object, field: str) -> list[Any]:
        if not isinstance(content, list):
            raise self._fail(field, f"is {content!r:.40}, not a list")
        return content

    def record(self, content: object, case: str) -> CrashRecord:
        whole = self._mapping(content, "")
        crash = self._mapping(whole.get("crash"), "crash")
        vehicles = tuple(
            self._vehicle(each, f"crash.vehicles[{place}]")
            for place, each in enumerate(self._list(crash.get("vehicles"), "crash.vehicles"))
        )
        numbers = [vehicle.number for vehicle in vehicles]
        if len({*numbers}) != len(numbers):
            raise self._fail("crash.vehicles", "gives one number to two vehicles")
        events = self._list(crash.get("collisions"), "crash.collisions")
        collisions = [self._collision(each, f"crash.collisions[{place}]") for place, each in enumerate(events)]
        roads, stem = self._road(crash.get("road"))
        also = (whole.get("oracle") or {}).get("alternatives", {}).get("road_type", [])
        roads = tuple(dict.fromkeys([*roads, *(each for each in also if each in ROADS)])) if roads else ()
        return CrashRecord(
            str(whole.get("case", case)),
            roads,
            vehicles,
            tuple(each for each in collisions if each is not None),
            stem,
            len(events),
        )

    def _road(self, content: object) -> tuple[tuple[str, ...], float | None]:
        if isinstance(content, Mapping):
            kind, stem = (
                content.get("road_type", content.get("type")),
                content.get("stem_direction", content.get("stem")),
            )
            alternatives = content.get("alternatives") or []
        else:
            kind, stem, alternatives = content, None, []
        kinds = [each for each in (kind if isinstance(kind, list) else [kind, *alternatives]) if each is not None]
        for each in kinds:
            if each not in ROADS:
                raise self._fail("crash.road", f"{each!r:.40} is none of {', '.join(ROADS)}")
        return tuple(kinds), self._heading(stem, "crash.road.stem")

    def _vehicle(self, content: object, field: str) -> RecordedVehicle:
        fields = self._mapping(content, field)
        return RecordedVehicle(
            self._number(fields.get("number"), f"{field}.number"),
            self._heading(fields.get("from"), f"{field}.from"),
            self._heading(fields.get("to"), f"{field}.to"),
            str(fields.get("manoeuvre") or "").lower(),
        )

    def _collision(self, content: object, field: str) -> RecordedCollision | None:
        fields = self._mapping(content, field)
        striking, struck = (fields.get(name) for name in ("striking", "struck"))
        if isinstance(striking, str) or isinstance(struck, str) or struck is None:
            return None  # an object, an animal or a person
        numbers = [
            self._number(value, f"{field}.{name}") for name, value in (("striking", striking), ("struck", struck))
        ]
        if numbers[0] == numbers[1]:
            raise self._fail(field, f"vehicle {numbers[0]} cannot collide with itself")
        parts = [self._part(fields.get(name), f"{field}.{name}") for name in ("striking_part", "struck_part")]
        return RecordedCollision(numbers[0], numbers[1], *parts)

    def _number(self, value: object, field: str) -> int:
        if isinstance(value, bool) or not isinstance(value, int) or value < 1:
            raise self._fail(field, f"{value!r:.40} is no vehicle's number, from 1")
        return value

    def _heading(self, value: object, field: str) -> float | None:
        if value is None:
            return None
        text = re.sub(r"bound$", "", str(value).strip().lower())
        name = "".join(
            _WORDS.get(part, part) for part in re.findall(r"north|south|east|west|.+?(?=north|south|east|west|$)", text)
        )
        if name.upper() not in HEADINGS:
            raise self._fail(field, f"{value!r:.40} is none of {', '.join(HEADINGS)}")
        return HEADINGS[name.upper()]

    def _part(self, value: object, field: str) -> Part | None:
        words = re.findall(r"[a-z]+", str(value or "").lower())
        if not words or {*words} & _UNKNOWN:
            return None
        strange = [word for word in words if word not in _FACES and word not in _SILENT]
        faces = {_FACES[word] for word in words if word in _FACES}
        along, across = faces & {"front", "rear"}, faces & {"left", "right"}
        if strange or len(along) > 1 or len(across) > 1 or not faces:
            raise self._fail(
                field, f"{value!r:.40} names no part of a vehicle; use front, rear, left, right or a corner"
            )
        return Part(" ".join([*along, *across]))
