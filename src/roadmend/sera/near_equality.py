"""Scenarios that differ in nothing but their name, or a little in their numbers, and their seed."""

import hashlib
import json
from typing import Any

from roadmend.world.scenario import Scenario

TOLERANCE = 0.02  # of a number, of 1 for those below
_NUMBER = "number"


def content_digest(scenario: Scenario) -> str:
    """The digest of a scenario without its name."""
    return scenario.model_copy(update={"name": "scenario"}).digest


def skeleton(scenario: Scenario) -> tuple[str, tuple[float, ...]]:
    """A digest of everything but the fractional numbers, name and seed; and those numbers in order."""
    numbers: list[float] = []
    content = scenario.model_dump(mode="json", exclude={"name", "seed"})
    bare = json.dumps(_bare(content, numbers), sort_keys=True)
    return hashlib.sha256(bare.encode()).hexdigest(), tuple(numbers)


def nearly_equal(one: tuple[float, ...], other: tuple[float, ...]) -> bool:
    """Whether two lists of numbers, of scenarios with the same skeleton, agree within the tolerance."""
    return all(abs(a - b) <= TOLERANCE * max(1.0, abs(a), abs(b)) for a, b in zip(one, other, strict=True))


def _bare(content: Any, numbers: list[float]) -> Any:
    match content:
        case float():
            numbers.append(content)
            return _NUMBER
        case dict():
            return {key: _bare(content[key], numbers) for key in sorted(content)}
        case list():
            return [_bare(each, numbers) for each in content]
        case _:
            return content
