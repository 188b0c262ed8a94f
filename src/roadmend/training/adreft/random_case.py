"""Scenarios drawn at random to practise on, beside those that searches have found.

A search's finds are each other's relatives: forty of them show one accident forty times. Scenarios drawn apart have
nothing in common but their family, and what blindness makes of them no search has shaped.
"""

import zlib
from dataclasses import dataclass

from roadmend.world.families import FAMILIES, sample_scenario
from roadmend.world.scenario import Scenario

FIRST_SEED = 40_000_000  # beyond those of every corpus, of the policies' training and of the scenario bank
_BLOCK = 100_000  # seeds of a policy
_BLOCKS = 1000
_VALIDATION = _BLOCK * _BLOCKS  # seeds between a policy's scenarios to practise on and those to validate by


@dataclass(frozen=True, slots=True)
class RandomCase:
    """A scenario that nobody has driven yet (``training.closed_loop.EpisodeCase``)."""

    family: str
    seed: int

    @property
    def name(self) -> str:
        """Name of the scenario."""
        return f"{self.family}-{self.seed}"

    @property
    def digest(self) -> str:
        """Nothing: what the policy makes of it is not known yet."""
        return ""

    @property
    def is_violation(self) -> bool:
        """Not known yet; few are."""
        return False

    def scenario(self) -> Scenario:
        """The scenario itself."""
        return sample_scenario(self.family, self.seed)


def random_cases(policy: str, number: int, *, validation: bool = False) -> list[RandomCase]:
    """So many scenarios of each family, the same ones for a policy at every call; other policies mostly get others.

    Args:
        policy: for which.
        number: of each family.
        validation: those that are never practised on, by which a model is judged.
    """
    seeds = practice_seeds(policy)[validation]
    return [RandomCase(family, seeds[index]) for index in range(number) for family in FAMILIES]


def practice_seeds(policy: str) -> tuple[range, range]:
    """The seeds of all scenarios that a policy's models may have practised on, and been validated by."""
    first = FIRST_SEED + _BLOCK * (zlib.crc32(policy.encode()) % _BLOCKS)
    return range(first, first + _BLOCK), range(first + _VALIDATION, first + _VALIDATION + _BLOCK)
