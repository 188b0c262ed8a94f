"""The scenario families, S1 to S5 of the evaluation (NHTSA pre-crash typology) and those of others; drawing from them."""

import random
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Annotated, Any

from pydantic import AfterValidator, WithJsonSchema

from roadmend.core.errors import ForeignError, InputError
from roadmend.core.foreign import blamed_on
from roadmend.core.registry import Registry
from roadmend.core.whole_number import whole_number
from roadmend.world.families.highway import EXIT_SPACE, RAMP_SPACE, build_exit, build_ramp
from roadmend.world.families.intersection import SPACE, build_intersection
from roadmend.world.scenario import Scenario
from roadmend.world.space import Parameters, Space, sample

LAST = 2**31 - 1  # number of a scenario, which is SUMO's seed too


@dataclass(frozen=True)
class Family:
    """A kind of traffic situation: a parameter space and what its points mean."""

    name: str
    title: str
    space: Space
    build: Callable[[Parameters, str, int], Scenario]


FAMILIES: dict[str, Family] = {
    "S1": Family("S1", "left turn", SPACE, partial(build_intersection, "S1")),
    "S2": Family("S2", "right turn", SPACE, partial(build_intersection, "S2")),
    "S3": Family("S3", "crossing an intersection", SPACE, partial(build_intersection, "S3")),
    "S4": Family("S4", "highway exit", EXIT_SPACE, build_exit),
    "S5": Family("S5", "on-ramp merging", RAMP_SPACE, build_ramp),
}


def _of_object(given: str, thing: Any) -> Family:
    """A family from outside; what it builds is looked at."""
    where = f"family {given}"
    if not isinstance(thing, Family):
        raise InputError(where, f"is no Family but {type(thing).__name__}", "see roadmend.world.families.Family")
    _check_space(where, thing.space)

    def build(parameters: Parameters, name: str, seed: int) -> Scenario:
        with blamed_on(where, "build"):
            scenario: Any = thing.build(parameters, name, seed)
        if not isinstance(scenario, Scenario):
            raise ForeignError(where, f"build answered with {type(scenario).__name__}", "answer with a Scenario")
        return scenario

    return Family(given, thing.title, thing.space, build)


def _check_space(where: str, space: Any) -> None:
    """Raise InputError unless it has dimensions, and each can be drawn."""
    mend = "see roadmend.world.space for what one has"
    if not isinstance(space, Mapping) or not space:
        raise InputError(where, "its space is no dictionary that holds a dimension", mend)
    for name, dimension in space.items():
        is_dimension = all(callable(getattr(dimension, method, None)) for method in ("sample", "contains"))
        if not isinstance(name, str) or not is_dimension:
            raise InputError(where, f"its space has {name!r}, which is {type(dimension).__name__}", mend)
        try:
            with blamed_on(where, f"drawing {name!r}"):
                dimension.sample(random.Random(0))
        except ForeignError as error:
            raise InputError(where, error.what, mend) from None


FAMILY_REGISTRY = Registry("family", "roadmend.families", FAMILIES, _of_object)


def family_of(given: str) -> Family:
    """A family by name, or as ``package.module:OBJECT``.

    Raises:
        InputError: there is none, or it is no Family.
    """
    return FAMILY_REGISTRY.find(given).entry


def _known(name: str) -> str:
    if name not in FAMILIES:
        raise ValueError(f"there is no family {name!r}")
    return name


FamilyName = Annotated[str, AfterValidator(_known), WithJsonSchema({"type": "string", "enum": list(FAMILIES)})]


def sample_scenario(family: str, seed: int) -> Scenario:
    """Draw a scenario; the same family and seed give the same scenario.

    Raises:
        InputError: there is no such family, or the seed is no whole number from 0 to ``LAST``.
    """
    seed = whole_number("seed", seed)
    if seed > LAST:
        raise InputError("seed", f"{seed} is beyond the last scenario of a family", f"stay up to number {LAST}")
    found = FAMILY_REGISTRY.find(family)
    parameters = sample(found.entry.space, random.Random(f"roadmend/{family}/{seed}"))
    return found.entry.build(parameters, f"{found.label}-{seed}", seed)
