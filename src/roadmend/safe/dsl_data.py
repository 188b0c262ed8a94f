"""A scenario as plain data, the shape that JSON and YAML share, and back, strictly."""

import json
import sys
from collections.abc import Iterator, Mapping, Sequence
from enum import StrEnum
from typing import Any, TypeVar

from roadmend.core.errors import InputError
from roadmend.safe.dsl import (
    EXTRA_PREFIX,
    Action,
    Compass,
    Control,
    Coordinates,
    CrashScenario,
    DescribedCollision,
    DescribedEnvironment,
    DescribedImpact,
    DescribedRoadNetwork,
    DescribedVehicle,
    DslModel,
    Manoeuvre,
    Position,
    RoadType,
    Side,
    StruckObject,
    Time,
    Weather,
    is_extra_name,
)
from roadmend.safe.stated import why_unusable

Word = TypeVar("Word", bound=StrEnum)
Lines = Mapping[str, int]  # field -> line of the file, from 1

NOT_APPLICABLE = "Not applicable"
_BEYOND = ("collisions", "impacts", "is_divided", "bend", "control")  # parts that the paper does not have
_OF_IMPACT = ("object", "striking_side", "roadside")  # where known
LONGEST_FIELD = 200  # [characters] of the way to a field of the language
_MEND = "see 'The scenario language' in src/doc/safe.md"


def dump_data(scenario: CrashScenario) -> dict[str, Any]:
    """The scenario as plain data; what is open is None, and what was not given beyond the grammar is left out."""
    content: dict[str, Any] = {
        "road_type": _word(scenario.road.road_type),
        "num_lanes": scenario.road.lanes,
        "stem_direction": _word(scenario.road.stem),
        "vehicles": [_dump_vehicle(vehicle) for vehicle in scenario.vehicles],
        "env": {
            "time": _word(scenario.environment.time),
            "weather": _word(scenario.environment.weather),
            **scenario.environment.extras,
        },
    }
    beyond = {"is_divided": scenario.road.is_divided, "bend": scenario.road.bend, "control": scenario.road.control}
    content |= {
        name: str(value) if isinstance(value, StrEnum) else value for name, value in beyond.items() if value is not None
    }
    if scenario.collisions:
        content["collisions"] = [_dump_collision(collision) for collision in scenario.collisions]
    if scenario.impacts:
        content["impacts"] = [_dump_impact(impact) for impact in scenario.impacts]
    return content | dict(scenario.extras)


def _dump_vehicle(vehicle: DescribedVehicle) -> dict[str, Any]:
    action = [list(point) for point in vehicle.action] if isinstance(vehicle.action, tuple) else _word(vehicle.action)
    content = {
        "model": _word(vehicle.model),
        "initial_position": _word(vehicle.initial_position),
        "action": action,
        "speed_limit_mph": vehicle.speed_limit_mph,
    }
    if vehicle.manoeuvre is not None:
        content["manoeuvre"] = vehicle.manoeuvre.value
    return content | dict(vehicle.extras)


def _dump_collision(collision: DescribedCollision) -> dict[str, Any]:
    sides = {"striking_side": _word(collision.striking_side), "struck_side": _word(collision.struck_side)}
    return {"striking": collision.striking, "struck": collision.struck} | {
        name: side for name, side in sides.items() if side is not None
    }


def _dump_impact(impact: DescribedImpact) -> dict[str, Any]:
    words = {name: _word(getattr(impact, name)) for name in _OF_IMPACT}
    return {"striking": impact.striking} | {name: word for name, word in words.items() if word is not None}


def _word(word: StrEnum | None) -> str | None:
    return None if word is None else word.value


def parse_data(content: object, where: str, lines: Lines | None = None) -> CrashScenario:
    """Turn plain data into a scenario.

    Args:
        content: as ``dump_data`` gives it.
        where: what to call its source in an error.
        lines: where the fields stand, for errors.

    Raises:
        InputError: a field is unknown, missing or has a value that the language does not have; names line and field.
    """
    return _Parser(where, lines or {}).scenario(content)


class _Parser:
    """Walks through plain data; knows where it is."""

    def __init__(self, where: str, lines: Lines) -> None:
        self.where = where
        self.lines = lines

    def fail(self, field: str, problem: str, mend: str = _MEND) -> InputError:
        field = field if len(field) <= LONGEST_FIELD else f"{field[:60]}..."
        line = next((self.lines[name] for name in _outwards(field) if name in self.lines), None)
        place = f"{self.where}, line {line}" if line is not None else self.where
        return InputError(place, f"{f'field {field}: ' if field else ''}{problem}", mend)

    def mapping(
        self,
        content: object,
        field: str,
        needed: Sequence[str],
        optional: Sequence[str] = (),
        *,
        extensible: bool = True,
    ) -> tuple[Mapping[str, Any], dict[str, Any]]:
        if not isinstance(content, Mapping):
            raise self.fail(field, f"is {_shown(content)}, not fields with values")
        for name in content:
            if name not in needed and name not in optional and not (extensible and is_extra_name(str(name))):
                known = ", ".join([*needed, *optional])
                raise self.fail(
                    _join(field, _in_a_line(str(name))),
                    f"is none of {known}",
                    f"start fields of your own with {EXTRA_PREFIX} and write their names in a line, without < and >",
                )
        for name in needed:
            if name not in content:
                raise self.fail(_join(field, name), "is missing", "write null where the report does not say")
        extras = {str(name): value for name, value in content.items() if str(name).startswith(EXTRA_PREFIX)}
        for name, value in extras.items():
            try:
                json.dumps(value)
            except TypeError:
                what = f"holds what JSON does not have: {_shown(value)}"
                raise self.fail(_join(field, name), what, "write it in quotes, as a text") from None
        return content, extras

    def check_stated(self, extras: Mapping[str, Any], field: str = "") -> None:
        """Of fields of one's own, those that roads are built by hold what that asks for."""
        for name, value in extras.items():
            words = why_unusable(name, value, of_vehicle=bool(field))
            if words is not None:
                what = f"{_shown(value)} is not what a road is built by"
                raise self.fail(_join(field, name), what, f"give {words}, or null")

    def word(self, content: Mapping[str, Any], parent: str, name: str, words: type[Word]) -> Word | None:
        value = content.get(name)
        if value is None:
            return None
        try:
            return words(value)
        except ValueError:
            raise self.fail(
                _join(parent, name), f"{_shown(value)} is none of {', '.join(words)}", "take one of these, or null"
            ) from None

    def number(self, content: Mapping[str, Any], parent: str, name: str) -> float | None:
        value = content.get(name)
        if value is not None and not _is_number(value):
            raise self.fail(_join(parent, name), f"{_shown(value)} is no number", "give a number, or null")
        return value

    def truth(self, content: Mapping[str, Any], parent: str, name: str) -> bool | None:
        value = content.get(name)
        if value is not None and not isinstance(value, bool):
            raise self.fail(_join(parent, name), f"{_shown(value)} is neither true nor false", "give one, or null")
        return value

    def whole(self, content: Mapping[str, Any], parent: str, name: str) -> int | None:
        value = self.number(content, parent, name)
        if value is not None and not isinstance(value, int):
            raise self.fail(_join(parent, name), f"{_shown(value)} is no whole number", "give a whole number, or null")
        return value

    def scenario(self, content: object) -> CrashScenario:
        needed = ("road_type", "num_lanes", "stem_direction", "vehicles", "env")
        fields, extras = self.mapping(content, "", needed, _BEYOND)
        self.check_stated(extras)
        stem = {} if fields["stem_direction"] == NOT_APPLICABLE else fields
        road_type = self.word(fields, "", "road_type", RoadType)
        lanes, compass = self.whole(fields, "", "num_lanes"), self.word(stem, "", "stem_direction", Compass)
        vehicles = tuple(
            self.vehicle(vehicle, f"vehicles[{index}]") for index, vehicle in enumerate(self.items(fields, "vehicles"))
        )
        env, env_extras = self.mapping(fields["env"], "env", ("time", "weather"))
        environment = DescribedEnvironment(
            self.word(env, "env", "time", Time), self.word(env, "env", "weather", Weather), env_extras
        )
        collisions = tuple(
            self.collision(collision, f"collisions[{index}]")
            for index, collision in enumerate(self.items(fields, "collisions") if "collisions" in fields else ())
        )
        impacts = tuple(
            self.impact(impact, f"impacts[{index}]")
            for index, impact in enumerate(self.items(fields, "impacts") if "impacts" in fields else ())
        )
        try:
            return CrashScenario(
                DescribedRoadNetwork(
                    road_type,
                    lanes,
                    compass,
                    self.truth(fields, "", "is_divided"),
                    self.word(fields, "", "bend", Side),
                    self.word(fields, "", "control", Control),
                ),
                vehicles,
                environment,
                collisions,
                impacts,
                extras,
            )
        except ValueError as error:
            raise self.fail(str(error).split(maxsplit=1)[0], str(error).split(maxsplit=1)[1]) from None

    def items(self, fields: Mapping[str, Any], name: str) -> Sequence[object]:
        value = fields[name]
        if not isinstance(value, Sequence) or isinstance(value, str):
            raise self.fail(name, f"is {_shown(value)}, not a list")
        return value

    def vehicle(self, content: object, field: str) -> DescribedVehicle:
        needed = ("model", "initial_position", "action", "speed_limit_mph")
        fields, extras = self.mapping(content, field, needed, ("manoeuvre",))
        self.check_stated(extras, field)
        action = fields["action"]
        try:
            return DescribedVehicle(
                self.word(fields, field, "model", DslModel),
                self.word(fields, field, "initial_position", Position),
                self.points(action, f"{field}.action")
                if isinstance(action, Sequence) and not isinstance(action, str)
                else self.word(fields, field, "action", Action),
                self.number(fields, field, "speed_limit_mph"),
                self.word(fields, field, "manoeuvre", Manoeuvre),
                extras,
            )
        except ValueError as error:
            name, problem = str(error).split(maxsplit=1)
            raise self.fail(_join(field, name), problem) from None

    def points(self, content: Sequence[object], field: str) -> Coordinates:
        points = []
        for index, point in enumerate(content):
            pair = list(point) if isinstance(point, Sequence) and not isinstance(point, str) else []
            if len(pair) != 2 or not all(map(_is_number, pair)):
                raise self.fail(f"{field}[{index}]", f"{_shown(point)} is no point", "give [x, y] in metres")
            points.append((float(pair[0]), float(pair[1])))
        return tuple(points)

    def collision(self, content: object, field: str) -> DescribedCollision:
        fields, _ = self.mapping(
            content, field, ("striking", "struck"), ("striking_side", "struck_side"), extensible=False
        )
        striking, struck = (self.whole(fields, field, name) for name in ("striking", "struck"))
        if striking is None or struck is None:
            raise self.fail(field, "has no two vehicles", "give their numbers, from 1")
        sides = (self.word(fields, field, name, Side) for name in ("striking_side", "struck_side"))
        try:
            return DescribedCollision(striking, struck, *sides)
        except ValueError as error:
            raise self.fail(field, str(error)) from None

    def impact(self, content: object, field: str) -> DescribedImpact:
        fields, _ = self.mapping(content, field, ("striking",), _OF_IMPACT, extensible=False)
        striking = self.whole(fields, field, "striking")
        if striking is None:
            raise self.fail(_join(field, "striking"), "names no vehicle", "give its number, from 1")
        try:
            return DescribedImpact(
                striking,
                self.word(fields, field, "object", StruckObject),
                self.word(fields, field, "striking_side", Side),
                self.word(fields, field, "roadside", Side),
            )
        except ValueError as error:
            name, problem = str(error).split(maxsplit=1)
            raise self.fail(_join(field, name), problem) from None


def _outwards(field: str) -> Iterator[str]:
    """A field and what it stands in, from the inside out."""
    yield field
    while field:
        field = field[: max(field.rfind("."), field.rfind("["), 0)]
        yield field


def _join(parent: str, name: str) -> str:
    return f"{parent}.{name}" if parent else name


def _in_a_line(name: str) -> str:
    return name if name.isprintable() else repr(name)[1:-1]


def _is_number(value: object) -> bool:
    """Whether it is a finite number; a whole one may be beyond all others, in hexadecimal digits say."""
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= sys.float_info.max


def _shown(value: object) -> str:
    try:
        text = json.dumps(value, default=str)
    except TypeError:  # a name that YAML has and JSON has not, such as a date
        text = str(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
