"""A language model that answers rightly but for one planted field, stays by it, and passes itself whatever it is asked."""

import copy
import json
import random
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from roadmend.core.errors import InputError
from roadmend.language.chat import Reply, Request
from roadmend.safe.answer_schema import answer_schema
from roadmend.safe.dsl import CrashScenario, Position, RoadType, Side
from roadmend.safe.dsl_data import dump_data, parse_data
from roadmend.safe.reading_alignment import COLLISIONS, VEHICLES, agree, flat

BOTH, SCENARIO_ALONE, META_ALONE = "in both answers", "in the scenario alone", "in the meta message alone"
LEFT_OUT, INVENTED = "left out", "invented"
APART = frozenset({LEFT_OUT, INVENTED})  # kinds that are counted by themselves
_RAMPS = (Position.ON_RAMP.value, Position.MAIN_ROAD.value)
_KINDS = {  # of fields, by the end of their names
    "road_type": "road type",
    "num_lanes": "lanes",
    "stem_direction": "stem",
    "model": "model",
    "initial_position": "position",
    "action": "action",
    "speed_limit_mph": "limit",
    "manoeuvre": "manoeuvre",
    "time": "time",
    "weather": "weather",
    "striking_side": "side of the collision",
    "struck_side": "side of the collision",
}
_LIMITS = (15, 25, 30, 35, 40, 45, 50, 55, 60, 65, 70)


@dataclass(frozen=True, slots=True)
class Lie:
    """One false statement.

    Attributes:
        kind: of the field.
        field: that is false, as the JSON form calls it.
        where: in which of the two answers.
        scenario: what the model answers as the scenario.
        meta: what it answers as the meta message.
    """

    kind: str
    field: str
    where: str
    scenario: Mapping[str, Any]
    meta: Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class AnsweringModel:
    """Answers by purpose, the same every time, and finds every answer right."""

    scenario: Mapping[str, Any]
    meta: Mapping[str, Any]

    def ask(self, request: Request) -> Reply:
        """Answer one request."""
        answers: dict[str, Any] = {
            "meta_message": self.meta,
            "scenario": {"analysis": "", "scenario": self.scenario},
            "validation": {"verdict": "Pass", "problems": []},
        }
        return Reply(json.dumps(answers[request.purpose]), "liar")


def meta_of(data: Mapping[str, Any]) -> dict[str, Any]:
    """The meta message that goes with a scenario."""
    directions = [vehicle["initial_position"] for vehicle in data["vehicles"]]
    return {
        "analysis": "",
        "road_type": data["road_type"],
        "number_of_vehicles": len(directions),
        "driving_directions": directions,
    }


def lies(truth: CrashScenario, others: Mapping[str, Sequence[Any]], seed: str) -> list[Lie]:
    """One lie about each field that a report states, those about meta messages in each place, and further ones.

    Further, each field that is stated is left out once, and one that is not is invented.

    Args:
        truth: what the report says; open where it says nothing.
        others: by field, further values that are right as well.
        seed: decides what is said instead.
    """
    random_ = random.Random(seed)
    data = dump_data(truth)
    honest = meta_of(data)
    found = []
    for kind, field, false in _false_scenarios(truth, others, random_):
        meta = meta_of(false)
        if meta == honest:
            found.append(Lie(kind, field, SCENARIO_ALONE, false, honest))
        else:
            places = ((BOTH, false, meta), (SCENARIO_ALONE, false, honest), (META_ALONE, data, meta))
            found += [Lie(kind, field, *place) for place in places]
    for field, value in flat(truth).items():
        may_be_open = any(agree(field, None, other) for other in others.get(field, ()))
        if _kind(field) and field != "road_type" and value is not None and not may_be_open:
            without = copy.deepcopy(data)
            put(without, field, None)
            found.append(Lie(LEFT_OUT, field, SCENARIO_ALONE, without, honest))
    for field, false in _inventions(truth, others, random_):
        found.append(Lie(INVENTED, field, SCENARIO_ALONE, false, honest))
    return found


def _inventions(
    truth: CrashScenario, others: Mapping[str, Sequence[Any]], random_: random.Random
) -> Iterator[tuple[str, dict[str, Any]]]:
    for field, value in flat(truth).items():
        if value is not None or not _kind(field) or field in others or field.endswith("manoeuvre"):
            continue
        choices = [*_values(field, None)]
        random_.shuffle(choices)
        for choice in choices:
            false = _with(dump_data(truth), field, choice)
            if false is not None:
                yield field, false
                break


def put(data: Any, field: str, value: Any) -> None:
    """Set a field of plain data by its name."""
    *path, last = field.replace("[", ".[").split(".")
    for part in path:
        data = data[int(part[1:-1])] if part.startswith("[") else data[part]
    data[last] = value


def _kind(field: str) -> str | None:
    return _KINDS.get(field.rpartition(".")[2])


def _false_scenarios(
    truth: CrashScenario, others: Mapping[str, Sequence[Any]], random_: random.Random
) -> Iterator[tuple[str, str, dict[str, Any]]]:
    for field, value in flat(truth).items():
        kind = _kind(field)
        if kind is None or value is None:
            continue
        right = (value, *others.get(field, ()))
        choices = [each for each in _values(field, value) if not any(agree(field, each, known) for known in right)]
        random_.shuffle(choices)
        for choice in choices:
            false = _with(dump_data(truth), field, choice)
            if false is not None:
                yield kind, field, false
                break
    yield from _false_counts(truth, random_)
    yield from _false_order(truth)


def _values(field: str, value: Any) -> Sequence[Any]:
    """What may stand in a field, and could be taken for true."""
    name = field.rpartition(".")[2]
    if name == "num_lanes":
        return (1, 2, 3, 4, 5, 6)
    if name == "speed_limit_mph":
        return [limit for limit in _LIMITS if value is None or abs(limit - value) >= 5]
    if name == "initial_position":
        is_ramp = value in _RAMPS
        return [word.value for word in Position if (word.value in _RAMPS) == is_ramp]
    if name.endswith("_side"):
        return [side.value for side in Side]
    schema = answer_schema()["properties"]
    part = {"vehicles": schema["vehicles"]["items"]["properties"], "env": schema["env"]["properties"]}
    words = part.get(field.split("[", maxsplit=1)[0].split(".", maxsplit=1)[0], schema)[name]["enum"]
    return [word for word in words if word is not None]


def _with(data: dict[str, Any], field: str, value: Any) -> dict[str, Any] | None:
    """The scenario with a false field, and what the language forces along with it; None if that is not enough."""
    put(data, field, value)
    if field == "road_type":
        data["stem_direction"] = None
        for vehicle in data["vehicles"]:
            on_ramp = vehicle["initial_position"] in _RAMPS
            if (value == RoadType.MERGING and not on_ramp) or (value != RoadType.MERGING and on_ramp):
                vehicle["initial_position"] = None
    try:
        parse_data(data, "a lie")
    except InputError:
        return None
    return data


def _false_counts(truth: CrashScenario, random_: random.Random) -> Iterator[tuple[str, str, dict[str, Any]]]:
    """A vehicle too few, with all that is said of it, or one too many, which touches another one."""
    data = dump_data(truth)
    count = len(truth.vehicles)
    if count > 2 or (count == 2 and random_.random() < 0.5):
        data["vehicles"].pop()
        data["collisions"] = [
            each for each in data.get("collisions", ()) if count not in (each["striking"], each["struck"])
        ]
    else:
        data["vehicles"].append(copy.deepcopy(data["vehicles"][-1]))
        data.setdefault("collisions", []).append({"striking": count + 1, "struck": count, "striking_side": "Front"})
    yield "count of vehicles", VEHICLES, data


def _false_order(truth: CrashScenario) -> Iterator[tuple[str, str, dict[str, Any]]]:
    """Who ran into whom the other way round, and the collisions in another order."""
    for index, collision in enumerate(truth.collisions):
        if Side.FRONT not in (collision.striking_side, collision.struck_side):
            continue  # of two sides that scrape along each other neither runs into the other
        if collision.striking_side is collision.struck_side:
            continue
        data = dump_data(truth)
        told = data[COLLISIONS][index]
        told["striking"], told["struck"] = told["struck"], told["striking"]
        told["striking_side"], told["struck_side"] = told.get("struck_side"), told.get("striking_side")
        yield "order of the collision", f"{COLLISIONS}[{index}].striking", data
    if len(truth.collisions) > 1:
        data = dump_data(truth)
        data[COLLISIONS][0], data[COLLISIONS][1] = data[COLLISIONS][1], data[COLLISIONS][0]
        yield "order of the collision", f"{COLLISIONS}[0]", data
