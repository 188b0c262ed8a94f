"""Two readings of one report side by side: which vehicle of the one is which of the other, and what that makes of contacts."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import permutations
from typing import Any

from roadmend.safe.dsl import CrashScenario, DescribedCollision, Side, Weather
from roadmend.safe.dsl_data import dump_data

VEHICLES, COLLISIONS = "vehicles", "collisions"  # as fields: how many there are
IMPACTS = "impacts"
_LIMIT_SLACK = 1.5  # [mph] by which limits differ that were given in km/h
_ALIKE = ({Weather.SUNNY, Weather.CLEAR}, {Weather.CLOUDY, Weather.OVERCAST})  # words for one sky
_NUMBERED = re.compile(r"\b(?:v|vehicle|veh\.?|unit|car|driver)[\s#(no.-]{0,5}(?:[1-9]|one|two)\b", re.IGNORECASE)
_MOST = 5  # vehicles whose order is looked for
_MARGIN = 3  # fields by which another order has to fit better; one false field makes up two


@dataclass(frozen=True, slots=True)
class AlignedField:
    """What the other reading has in the place of a field.

    Attributes:
        value: in the numbering of the first one.
        field: by its own name, under which its evidence stands.
    """

    value: Any
    field: str


def agree(field: str, one: Any, other: Any) -> bool:
    """Whether two values of a field say the same."""
    if one == other:
        return True
    if one is None or other is None:
        return False
    if field.endswith("speed_limit_mph"):
        return all(isinstance(each, int | float) for each in (one, other)) and bool(abs(one - other) <= _LIMIT_SLACK)
    return field == "env.weather" and any({one, other} <= alike for alike in _ALIKE)


def flat(scenario: CrashScenario) -> dict[str, Any]:
    """The fields of a scenario by their names in the JSON form, and how many vehicles and collisions there are."""
    fields: dict[str, Any] = {VEHICLES: len(scenario.vehicles), COLLISIONS: len(scenario.collisions)}

    def walk(content: Any, name: str) -> None:
        if isinstance(content, Mapping):
            for key, value in content.items():
                walk(value, f"{name}.{key}" if name else str(key))
        elif name in {VEHICLES, COLLISIONS, IMPACTS}:
            for index, value in enumerate(content):
                walk(value, f"{name}[{index}]")
        else:
            fields[name] = tuple(map(tuple, content)) if isinstance(content, list) else content  # points of a way

    walk(dump_data(scenario), "")
    return fields


def aligned_fields(answered: CrashScenario, read: CrashScenario, summary: str) -> dict[str, AlignedField]:
    """The fields of a reading in the numbering of another, as far as both speak of the same vehicles and contacts.

    Args:
        answered: whose numbering counts.
        read: the other one.
        summary: that both are of; where it numbers the vehicles, their numbers stand.
    """
    places = _places(answered, read, is_numbered=bool(_NUMBERED.search(summary)))
    found = {}
    for name, value in flat(read).items():
        if name.startswith(f"{VEHICLES}["):
            index, rest = name[len(VEHICLES) + 1 :].split("]", 1)
            if int(index) in places:
                found[f"{VEHICLES}[{places[int(index)]}]{rest}"] = AlignedField(value, name)
        elif name.startswith(f"{IMPACTS}["):
            if name in flat(answered) and not name.endswith(".striking"):
                found[name] = AlignedField(value, name)
        elif not name.startswith(f"{COLLISIONS}["):
            found[name] = AlignedField(value, name)
    return found | _contacts(answered, read, places)


def renumbered_collisions(answered: CrashScenario, read: CrashScenario, summary: str) -> tuple[DescribedCollision, ...]:
    """The contacts of a reading between vehicles that the answer has too, in its numbers; arguments as above."""
    places = _places(answered, read, is_numbered=bool(_NUMBERED.search(summary)))
    return tuple(
        replace(each, striking=places[each.striking - 1] + 1, struck=places[each.struck - 1] + 1)
        for each in read.collisions
        if {each.striking - 1, each.struck - 1} <= places.keys()
    )


def _places(answered: CrashScenario, read: CrashScenario, *, is_numbered: bool) -> dict[int, int]:
    """For vehicles of a reading, from 0, which of the answer's they are."""
    one, other = len(answered.vehicles), len(read.vehicles)
    as_they_stand = {index: index for index in range(min(one, other))}
    if is_numbered or max(one, other) > _MOST:
        return as_they_stand
    if one >= other:
        orders = [dict(enumerate(order)) for order in permutations(range(one), other)]
    else:
        orders = [{place: index for index, place in enumerate(order)} for order in permutations(range(other), one)]
    best = max(orders, key=lambda order: _fit(answered, read, order))
    is_better = _fit(answered, read, best) >= _fit(answered, read, as_they_stand) + _MARGIN
    return best if is_better else as_they_stand


def _fit(answered: CrashScenario, read: CrashScenario, places: Mapping[int, int]) -> int:
    """In how many fields vehicles agree, less those in which they do not; contacts count double."""
    fit = 0
    fields, others = flat(answered), flat(read)
    for index, place in places.items():
        for name in ("model", "initial_position", "action", "speed_limit_mph"):
            mine, theirs = fields[f"{VEHICLES}[{place}].{name}"], others[f"{VEHICLES}[{index}].{name}"]
            if mine is not None and theirs is not None:
                fit += 1 if agree(name, mine, theirs) else -1
    pairs = {(each.striking - 1, each.struck - 1) for each in answered.collisions}
    for each in read.collisions:
        pair = (places.get(each.striking - 1), places.get(each.struck - 1))
        fit += 2 * ((pair in pairs) - (pair[::-1] in pairs))
    return fit


def _contacts(answered: CrashScenario, read: CrashScenario, places: Mapping[int, int]) -> dict[str, AlignedField]:
    """The contacts that both have in one place, told from the side of the answer's striking vehicle where that is open."""
    found: dict[str, AlignedField] = {}
    for index, (mine, theirs) in enumerate(zip(answered.collisions, read.collisions, strict=False)):
        name = f"{COLLISIONS}[{index}]"
        if theirs.striking - 1 not in places or theirs.struck - 1 not in places:
            continue
        pair = (places[theirs.striking - 1] + 1, places[theirs.struck - 1] + 1)
        sides = (theirs.striking_side, theirs.struck_side)
        parts = ("striking", "struck", "striking_side", "struck_side")
        own = parts
        if pair == (mine.struck, mine.striking):
            sides, own = (sides[1], sides[0]), (*parts[1::-1], *parts[:1:-1])
            if None not in sides and (Side.FRONT not in sides or sides[0] is sides[1]):
                # Then neither runs into the other.
                pair = (mine.striking, mine.struck)
        for part, their_part, value in zip(parts, own, (*pair, *sides), strict=True):
            plain = value.value if isinstance(value, Side) else value
            found[f"{name}.{part}"] = AlignedField(plain, f"{name}.{their_part}")
    return found
