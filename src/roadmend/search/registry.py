"""The search techniques by name."""

import random
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from roadmend.core.errors import InputError
from roadmend.core.settings import check_parameters
from roadmend.search.avfuzzer import AvFuzzer, AvFuzzerParameters
from roadmend.search.behavexplor import BehAVExplor, BehAVExplorParameters
from roadmend.search.random_draws import RandomDraws, RandomDrawsParameters
from roadmend.search.technique import Technique, TechniqueParameters
from roadmend.world.space import Space


@dataclass(frozen=True, slots=True)
class TechniqueEntry:
    """How a technique is made."""

    parameters: type[TechniqueParameters]
    make: Callable[[Space, random.Random, Any], Technique]  # from an instance of ``parameters``


TECHNIQUES: dict[str, TechniqueEntry] = {
    "random": TechniqueEntry(RandomDrawsParameters, RandomDraws),
    "avfuzzer": TechniqueEntry(AvFuzzerParameters, AvFuzzer),
    "behavexplor": TechniqueEntry(BehAVExplorParameters, BehAVExplor),
}


def read_technique_parameters(name: str, values: Mapping[str, Any] | None = None) -> TechniqueParameters:
    """Parameters of a technique; ``values`` replace single defaults.

    Raises:
        InputError: there is no such technique, or a parameter is unknown or out of range.
    """
    if name not in TECHNIQUES:
        raise InputError("technique", f"there is no {name!r}", f"choose one of {', '.join(TECHNIQUES)}")
    return check_parameters(values, TECHNIQUES[name].parameters, f"technique {name}")


def make_technique(name: str, space: Space, seed: int, parameters: TechniqueParameters | None = None) -> Technique:
    """A technique by name.

    Args:
        name: a key of TECHNIQUES.
        space: what it moves through.
        seed: of its chance.
        parameters: an instance of what the technique's entry names; its defaults if not given.

    Raises:
        InputError: there is no such technique.
    """
    chosen = parameters if parameters is not None else read_technique_parameters(name)
    return TECHNIQUES[name].make(space, random.Random(f"roadmend/search/{name}/{seed}"), chosen)
