"""Records of real crashes: what is known of a crash apart from any reading of its report by a program.

A record is a file CASE.json that a person wrote (or the coded fields of an investigation gave). It says who ran into
whom, with which part, coming from and going to where, and on which road::

    {"case": "...", "crash": {"road": "Intersection",
      "vehicles": [{"number": 1, "from": "N", "to": "W", "manoeuvre": "turn left"}, ...],
      "collisions": [{"striking": 2, "struck": 1, "striking_part": "front", "struck_part": "rear-left"}, ...],
      "doubt": ""}, "annotator": "..."}

``from`` is the direction of travel before the crash and ``to`` the one that the vehicle meant to take, as points of the
compass; a T-intersection may have a ``stem``. What is null is not known, and not asked of anybody. A record may also
carry the scenario that a careful reader takes from the report, as ``oracle``; of it, the judge goes by the alternatives
of the road's type alone. Who strikes or is struck is one of the vehicles, by its number, or stands there in words, such
as "object: tree".
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

from roadmend.core.bounds import CRASH
from roadmend.core.errors import InputError
from roadmend.core.json_text import read_json
from roadmend.core.settings import check_settings
from roadmend.safe.contact import Part

HEADINGS: dict[str, float] = {  # [deg] counter-clockwise from east
    name: 45.0 * place for place, name in enumerate(("E", "NE", "N", "NW", "W", "SW", "S", "SE"))
}
_MEND = "the form of records is on src/doc/safe.md"

# Beginnings of words by which a record's own name of what was struck tells what that is; the first kind counts. Whole
# words where others begin alike: a dogwood is no dog, cargo no car, and a horse trailer no horse.
_THINGS = {
    "on the roadway": r"deer|elk|moose|animal|horse(?!s?\W+trailer)|cow|dogs?\b|pedestrian|(bi)?cycl|person|debris",
    "along the road": "ditch|embankment|curb|kerb|wall|fence|guard|rail|barrier|hedge|culvert",
    "vehicle": r"trailer|vehicle|cars?\b|truck",
    "upright": "tree|pole|sign|post|sapling|branch|bush|hydrant|mailbox|tower|pillar",
}

_Road = Literal["Straight", "Curve", "Intersection", "T-intersection", "Merging"]
_Heading = Literal["E", "NE", "N", "NW", "W", "SW", "S", "SE"]
_Number = Annotated[int, Field(ge=1, strict=True)]
_IN_QUOTES = re.compile(r"\W*(?:v|vehicle)?\W*\d[\d\W]*", re.IGNORECASE)  # a vehicle of the record, as a text


class RecordedManoeuvre(StrEnum):
    """What a vehicle of a record does."""

    MOVE_FORWARD = "move forward"
    TURN_LEFT = "turn left"
    TURN_RIGHT = "turn right"
    CHANGE_LANE_LEFT = "change lane left"
    CHANGE_LANE_RIGHT = "change lane right"
    DRIFT_LEFT = "drift left"
    DRIFT_RIGHT = "drift right"
    U_TURN = "u-turn"
    REVERSE = "reverse"
    STOP = "stop"
    PARKED = "parked"
    LEAVE_DRIVEWAY = "leave driveway"
    ENTER_DRIVEWAY = "enter driveway"
    MERGE = "merge"
    RUN_OFF_ROAD = "run off road"
    WRONG_WAY = "wrong way"


_SIDES = {
    RecordedManoeuvre.DRIFT_LEFT: 1,
    RecordedManoeuvre.CHANGE_LANE_LEFT: 1,
    RecordedManoeuvre.DRIFT_RIGHT: -1,
    RecordedManoeuvre.CHANGE_LANE_RIGHT: -1,
}


@dataclass(frozen=True, slots=True)
class RecordedVehicle:
    """What is known of one vehicle.

    Attributes:
        number: the report's, from 1.
        origin: heading before the crash [deg], counter-clockwise from east; None where it is not known.
        destination: heading that it was going to have [deg]; None where it is not known.
        manoeuvre: what it does; None where it is not known.
    """

    number: int
    origin: float | None
    destination: float | None
    manoeuvre: RecordedManoeuvre | None = None

    @property
    def stands(self) -> bool:
        """Whether it stood when it was hit: stopped or parked."""
        return self.manoeuvre in {RecordedManoeuvre.STOP, RecordedManoeuvre.PARKED}

    @property
    def reverses(self) -> bool:
        """Whether it went backwards."""
        return self.manoeuvre is RecordedManoeuvre.REVERSE

    @property
    def leaves(self) -> int:
        """The side to which it left its way: 1 to the left, -1 to the right, 0 where that is not known."""
        return _SIDES.get(self.manoeuvre, 0) if self.manoeuvre is not None else 0


@dataclass(frozen=True, slots=True)
class RecordedCollision:
    """Two vehicles of the record come to touch, by number, with the parts as far as they are known."""

    striking: int
    struck: int
    striking_part: Part | None = None
    struck_part: Part | None = None


class RecordedThing(StrEnum):
    """What a vehicle struck that is none, as far as a judge tells it apart."""

    ON_THE_ROADWAY = "on the roadway"  # an animal, a person, debris
    ALONG_THE_ROAD = "along the road"  # a ditch, a curb, a wall, a barrier
    VEHICLE = "vehicle"  # one that stands there and is no vehicle of the record: a trailer
    UPRIGHT = "upright"  # a tree, a pole, a sign


@dataclass(frozen=True, slots=True)
class RecordedImpact:
    """A vehicle of the record strikes what is none of its vehicles.

    Attributes:
        striking: number of the vehicle.
        striking_part: what it hits with; None where it is not known.
        thing: what it strikes; None where the record's words tell no kind.
        on_roadway: whether that happened on the roadway, or beside it; None where it is not known.
    """

    striking: int
    striking_part: Part | None = None
    thing: RecordedThing | None = None
    on_roadway: bool | None = None


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
        impacts: of vehicles with objects, animals and people, in order.
    """

    case: str
    roads: tuple[str, ...]
    vehicles: tuple[RecordedVehicle, ...]
    collisions: tuple[RecordedCollision, ...]
    stem: float | None = None
    events: int = 0
    impacts: tuple[RecordedImpact, ...] = ()

    @property
    def is_alone(self) -> bool:
        """Whether a vehicle crashed alone: no two vehicles touched, and one struck something else."""
        return not self.collisions and bool(self.impacts)

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
    return check_settings(content, _RecordFile, str(path), _MEND).record(path.stem)


class _Fields(BaseModel):
    model_config = ConfigDict(extra="forbid")


class _VehicleFields(_Fields):
    number: _Number
    origin: _Heading | None = Field(None, alias="from")
    to: _Heading | None = None
    manoeuvre: RecordedManoeuvre | None = None

    def vehicle(self) -> RecordedVehicle:
        origin, destination = (None if name is None else HEADINGS[name] for name in (self.origin, self.to))
        return RecordedVehicle(self.number, origin, destination, self.manoeuvre)


class _CollisionFields(_Fields):
    striking: _Number | str | None  # text: an object, an animal or a person
    struck: _Number | str | None
    striking_part: Part | None = None
    struck_part: Part | None = None

    @model_validator(mode="after")
    def _of_two(self) -> "_CollisionFields":
        if self.striking is not None and self.striking == self.struck:
            raise ValueError(f"vehicle {self.striking} cannot collide with itself")
        for each in (self.striking, self.struck):
            if isinstance(each, str) and _IN_QUOTES.fullmatch(each):
                raise ValueError(f"{each!r} would be an object; a vehicle is its number alone, without quotes")
        return self

    def collision(self) -> RecordedCollision | None:
        """That of two vehicles; None for all others."""
        if not isinstance(self.striking, int) or not isinstance(self.struck, int):
            return None
        return RecordedCollision(self.striking, self.struck, self.striking_part, self.struck_part)

    def impact(self, manoeuvres: Mapping[int, RecordedManoeuvre | None]) -> RecordedImpact | None:
        """That of a vehicle with what is none; None for all others."""
        parts = {self.striking: self.striking_part, self.struck: self.struck_part}
        numbers = [each for each in parts if isinstance(each, int)]
        words = [each.lower() for each in parts if isinstance(each, str)]
        if len(numbers) != 1 or not words:
            return None
        thing = next((kind for kind, known in _THINGS.items() if re.search(rf"\b({known})", words[0])), None)
        kind = RecordedThing(thing) if thing is not None else None
        is_off = manoeuvres.get(numbers[0]) is RecordedManoeuvre.RUN_OFF_ROAD
        place = kind is RecordedThing.ON_THE_ROADWAY if kind is not None else False if is_off else None
        return RecordedImpact(numbers[0], parts[numbers[0]], kind, place)


class _CrashFields(_Fields):
    road: _Road | None
    stem: _Heading | None = None
    vehicles: list[_VehicleFields]
    collisions: list[_CollisionFields]
    doubt: str = ""

    @model_validator(mode="after")
    def _numbered(self) -> "_CrashFields":
        numbers = [each.number for each in self.vehicles]
        if len({*numbers}) != len(numbers):
            raise ValueError("one number is given to two vehicles")
        for place, each in enumerate(self.collisions, 1):
            for number in (each.striking, each.struck):
                if isinstance(number, int) and number not in numbers:
                    raise ValueError(f"collision {place} is of vehicle {number}, which is none of the vehicles")
        return self


class _AlternativeFields(BaseModel):
    road_type: list[_Road] = Field(default_factory=list)


class _OracleFields(BaseModel):
    alternatives: _AlternativeFields = _AlternativeFields()


class _RecordFile(_Fields):
    case: str = ""
    crash: _CrashFields
    oracle: _OracleFields | None = None
    annotator: str = ""

    def record(self, name: str) -> CrashRecord:
        crash = self.crash
        also = self.oracle.alternatives.road_type if self.oracle is not None else []
        collisions = [each.collision() for each in crash.collisions]
        manoeuvres = {each.number: each.manoeuvre for each in crash.vehicles}
        impacts = [each.impact(manoeuvres) for each in crash.collisions]
        return CrashRecord(
            self.case or name,
            (crash.road, *(each for each in also if each != crash.road)) if crash.road is not None else (),
            tuple(each.vehicle() for each in crash.vehicles),
            tuple(each for each in collisions if each is not None),
            None if crash.stem is None else HEADINGS[crash.stem],
            len(collisions),
            tuple(each for each in impacts if each is not None),
        )
