"""The search techniques: ours by name, and those of others."""

import random
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from roadmend.core.foreign import ForeignClass
from roadmend.core.parameters import Parameters
from roadmend.core.registry import Registry
from roadmend.core.settings import check_parameters
from roadmend.search.avfuzzer import AvFuzzer, AvFuzzerParameters
from roadmend.search.behavexplor import BehAVExplor, BehAVExplorParameters
from roadmend.search.foreign import ForeignTechnique
from roadmend.search.random_draws import RandomDraws, RandomDrawsParameters
from roadmend.search.technique import Technique
from roadmend.world.space import Space


@dataclass(frozen=True, slots=True)
class TechniqueEntry:
    """How a technique is made."""

    parameters: type[Parameters]
    make: Callable[[Space, random.Random, Any], Technique]  # from an instance of ``parameters``


TECHNIQUES: dict[str, TechniqueEntry] = {
    "random": TechniqueEntry(RandomDrawsParameters, RandomDraws),
    "avfuzzer": TechniqueEntry(AvFuzzerParameters, AvFuzzer),
    "behavexplor": TechniqueEntry(BehAVExplorParameters, BehAVExplor),
}


def _of_class(given: str, thing: Any) -> TechniqueEntry:
    found = ForeignClass.check(f"technique {given}", thing, Technique, ["space", "generator", "parameters"])

    def make(space: Space, generator: random.Random, parameters: Parameters) -> Technique:
        made: Technique = found.make(space=space, generator=generator, parameters=parameters)
        return ForeignTechnique(given, made)

    return TechniqueEntry(found.parameters, make)


TECHNIQUE_REGISTRY = Registry("technique", "roadmend.techniques", TECHNIQUES, _of_class)


def read_technique_parameters(name: str, values: Mapping[str, Any] | None = None) -> Parameters:
    """Parameters of a technique; ``values`` replace single defaults.

    Raises:
        InputError: there is no such technique, or a parameter is unknown or out of range.
    """
    return check_parameters(values, TECHNIQUE_REGISTRY.find(name).entry.parameters, f"technique {name}")


def make_technique(name: str, space: Space, seed: int, parameters: Parameters | None = None) -> Technique:
    """A technique by name.

    Args:
        name: of ours or of an installed package's, or ``package.module:Class``.
        space: what it moves through.
        seed: of its chance.
        parameters: an instance of what the technique's entry names; its defaults if not given.

    Raises:
        InputError: there is no such technique.
    """
    chosen = parameters if parameters is not None else read_technique_parameters(name)
    return TECHNIQUE_REGISTRY.find(name).entry.make(space, random.Random(f"roadmend/search/{name}/{seed}"), chosen)
