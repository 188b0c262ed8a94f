"""The scenario families by name, S1 to S5 of the evaluation (NHTSA pre-crash typology), and how to draw from them."""

import random
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Annotated

from pydantic import AfterValidator, WithJsonSchema

from roadmend.core.errors import InputError
from roadmend.world.families.highway import EXIT_SPACE, RAMP_SPACE, build_exit, build_ramp
from roadmend.world.families.intersection import SPACE, build_intersection
from roadmend.world.scenario import Scenario
from roadmend.world.space import Parameters, Space, sample


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


def _known(name: str) -> str:
    if name not in FAMILIES:
        raise ValueError(f"there is no family {name!r}")
    return name


FamilyName = Annotated[str, AfterValidator(_known), WithJsonSchema({"type": "string", "enum": list(FAMILIES)})]


def sample_scenario(family: str, seed: int) -> Scenario:
    """Draw a scenario; the same family and seed give the same scenario.

    Raises:
        InputError: there is no such family.
    """
    if family not in FAMILIES:
        raise InputError("family", f"there is no {family!r}", f"choose one of {', '.join(FAMILIES)}")
    chosen = FAMILIES[family]
    parameters = sample(chosen.space, random.Random(f"roadmend/{family}/{seed}"))
    return chosen.build(parameters, f"{family}-{seed}", seed)
