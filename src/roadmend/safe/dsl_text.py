"""The text form of a scenario, as in listing 2 of the paper, and back."""

import json
import re
from dataclasses import dataclass, field
from typing import Any

from roadmend.core.bounds import ARGUMENT
from roadmend.core.errors import InputError
from roadmend.core.json_text import parse_json
from roadmend.safe.dsl import EXTRA_PREFIX, CrashScenario, RoadType
from roadmend.safe.dsl_data import NOT_APPLICABLE, dump_data, parse_data

_UNKNOWN = "Unknown"
# The value is stripped afterwards: a pattern that leaves out the spaces around it looks at each of them from each of them.
_LINE = re.compile(r"(?P<indent> *)<(?P<name>[^<>]+)>\s*:(?P<value>.*)$")
_VEHICLE = {
    "Model": "model",
    "Initial_position": "initial_position",
    "Actions": "action",
    "Speed_limit": "speed_limit_mph",
    "Manoeuvre": "manoeuvre",
}
_ROAD = {"Road type": "road_type", "No. lanes": "num_lanes", "Stem direction": "stem_direction"}
_ROAD_BEYOND = {"Divided": "is_divided", "Bend": "bend", "Control": "control"}
_ENV = {"Time": "time", "Weather": "weather"}
_COLLISION = {
    "Striking": "striking",
    "Struck": "struck",
    "Striking_side": "striking_side",
    "Struck_side": "struck_side",
}
_PARTS = {"Actors": "vehicles", "Env": "env", "Collisions": "collisions", "Impacts": "impacts"}
_IMPACT = {"Striking": "striking", "Object": "object", "Striking_side": "striking_side", "Roadside": "roadside"}
_JSON = {"num_lanes", "speed_limit_mph", "striking", "struck", "is_divided"}


def dump_text(scenario: CrashScenario) -> str:
    """The scenario in the text form; what is open is Unknown."""
    data = dump_data(scenario)
    lines = ["<Scenario>:", "  <Road network>:"]
    stem_applies = scenario.road.road_type is RoadType.T_INTERSECTION
    for name, key in _ROAD.items():
        absent = _UNKNOWN if key != "stem_direction" or stem_applies else NOT_APPLICABLE
        lines.append(f"    <{name}>: {absent if data[key] is None else data[key]}")
    lines += _dump_fields({key: value for key, value in data.items() if key in _ROAD_BEYOND.values()}, _ROAD_BEYOND, 4)
    lines.append("  <Actors>:")
    for number, vehicle in enumerate(data["vehicles"], start=1):
        lines += [f"    <Vehicle_{number}>:", *_dump_fields(vehicle, _VEHICLE, 6)]
    lines += ["  <Env>:", *_dump_fields(data["env"], _ENV, 4)]
    if scenario.collisions:
        lines.append("  <Collisions>:")
        for number, collision in enumerate(data["collisions"], start=1):
            lines += [f"    <Collision_{number}>:", *_dump_fields(collision, _COLLISION, 6)]
    if scenario.impacts:
        lines.append("  <Impacts>:")
        for number, impact in enumerate(data["impacts"], start=1):
            lines += [f"    <Impact_{number}>:", *_dump_fields(impact, _IMPACT, 6)]
    lines += [f"  <{name}>: {json.dumps(value)}" for name, value in scenario.extras.items()]
    return "\n".join(lines) + "\n"


def _dump_fields(content: dict[str, Any], names: dict[str, str], indent: int) -> list[str]:
    lines = [f"{' ' * indent}<{name}>: {_shown(content[key])}" for name, key in names.items() if key in content]
    extras = [
        f"{' ' * indent}<{key}>: {json.dumps(value)}" for key, value in content.items() if key not in names.values()
    ]
    return lines + extras


def _shown(value: Any) -> str:
    return _UNKNOWN if value is None else json.dumps(value) if isinstance(value, list | bool) else str(value)


@dataclass(slots=True)
class _Entry:
    """One line of the text with the lines that belong to it."""

    name: str
    value: str
    line: int
    indent: int
    parts: list["_Entry"] = field(default_factory=list)


def parse_text(text: str, where: str) -> CrashScenario:
    """Read the text form.

    Args:
        text: one field a line, what belongs to a field indented below it.
        where: what to call its source in an error.

    Raises:
        InputError: names line and field at fault.
    """
    root = _outline(text, where)
    lines: dict[str, int] = {}
    reader = _Reader(where, lines)
    content = reader.scenario(root)
    return parse_data(content, where, lines)


def _outline(text: str, where: str) -> _Entry:
    top = _Entry("", "", 0, -1)
    stack = [top]
    for number, line in enumerate(text.splitlines(), start=1):
        if not line.strip():
            continue
        match = _LINE.match(line)
        if match is None:
            raise InputError(
                f"{where}, line {number}", f"{line.strip()[:60]!r} is no '<Field>: value'", "mend the line"
            )
        entry = _Entry(match["name"], match["value"].strip(), number, len(match["indent"]))
        while stack[-1].indent >= entry.indent:
            stack.pop()
        stack[-1].parts.append(entry)
        stack.append(entry)
    if [entry.name for entry in top.parts] != ["Scenario"]:
        raise InputError(
            where, "does not consist of one <Scenario>", "start with '<Scenario>:' and indent the rest below"
        )
    return top.parts[0]


class _Reader:
    """Turns the outline into plain data and notes on which line each field stands."""

    def __init__(self, where: str, lines: dict[str, int]) -> None:
        self.where = where
        self.lines = lines

    def fail(self, entry: _Entry, problem: str) -> InputError:
        return InputError(f"{self.where}, line {entry.line}", f"field <{entry.name}>: {problem}", "mend the line")

    def scenario(self, root: _Entry) -> dict[str, Any]:
        self.check_has_no_value(root)
        content: dict[str, Any] = {}
        seen: set[str] = set()
        for entry in root.parts:
            if entry.name in seen:
                raise self.fail(entry, "is there twice")
            seen.add(entry.name)
            match entry.name:
                case "Road network":
                    content |= self.fields(entry, _ROAD | _ROAD_BEYOND, "")
                case "Actors":
                    content["vehicles"] = self.numbered(entry, "Vehicle", _VEHICLE, "vehicles")
                case "Env":
                    content["env"] = self.fields(entry, _ENV, "env")
                case "Collisions":
                    content["collisions"] = self.numbered(entry, "Collision", _COLLISION, "collisions")
                case "Impacts":
                    content["impacts"] = self.numbered(entry, "Impact", _IMPACT, "impacts")
                case name if name.startswith(EXTRA_PREFIX):
                    self.check_has_no_parts(entry)
                    content[name] = self.json(entry)
                case _:
                    raise self.fail(entry, "is none of Road network, Actors, Env, Collisions, Impacts")
            self.lines.setdefault(_PARTS.get(entry.name, ""), entry.line)
        return content

    def numbered(self, parent: _Entry, kind: str, names: dict[str, str], path: str) -> list[dict[str, Any]]:
        self.check_has_no_value(parent)
        items = []
        for number, entry in enumerate(parent.parts, start=1):
            if entry.name != f"{kind}_{number}":
                raise self.fail(entry, f"stands where {kind}_{number} is expected")
            self.lines[f"{path}[{number - 1}]"] = entry.line
            items.append(self.fields(entry, names, f"{path}[{number - 1}]"))
        return items

    def fields(self, parent: _Entry, names: dict[str, str], path: str) -> dict[str, Any]:
        self.check_has_no_value(parent)
        content: dict[str, Any] = {}
        for entry in parent.parts:
            key = names.get(entry.name, entry.name)
            if key in content:
                raise self.fail(entry, "is there twice")
            self.check_has_no_parts(entry)
            self.lines[f"{path}.{key}" if path else key] = entry.line
            is_extra = entry.name.startswith(EXTRA_PREFIX) and path not in {"", "collisions", "impacts"}
            if entry.name not in names and not is_extra:
                raise self.fail(entry, f"is none of {', '.join(names)}")
            content[key] = self.json(entry) if is_extra else self.value(entry, key)
        return content

    def check_has_no_value(self, entry: _Entry) -> None:
        if entry.value:
            raise self.fail(entry, f"has the value {entry.value[:60]!r}, but holds fields")

    def check_has_no_parts(self, entry: _Entry) -> None:
        if entry.parts:
            raise self.fail(entry.parts[0], f"does not belong below <{entry.name}>")

    def value(self, entry: _Entry, key: str) -> Any:
        if entry.value == "":
            raise self.fail(entry, f"is empty; write {_UNKNOWN} where the report does not say")
        if entry.value == _UNKNOWN or (entry.value == NOT_APPLICABLE and key == "stem_direction"):
            return None
        if key in _JSON or (key == "action" and entry.value.startswith("[")):
            return self.json(entry)
        return entry.value

    def json(self, entry: _Entry) -> Any:
        try:
            return parse_json(entry.value, self.where, ARGUMENT)
        except InputError:
            raise self.fail(entry, f"{entry.value[:60]!r} is no number, list or other JSON value") from None
