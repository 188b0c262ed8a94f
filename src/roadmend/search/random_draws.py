"""Random search: the baseline. Every point is drawn afresh and nothing is learned."""

import random
from collections.abc import Sequence

from pydantic import Field

from roadmend.search.evaluation import Trial
from roadmend.search.technique import TechniqueParameters
from roadmend.world.space import Parameters, Space, sample


class RandomDrawsParameters(TechniqueParameters):
    """What can be set."""

    batch: int = Field(16, ge=1, le=1000, description="points evaluated side by side")


class RandomDraws:
    """Draws from the space as scenario families do."""

    def __init__(self, space: Space, generator: random.Random, parameters: RandomDrawsParameters) -> None:
        self._space, self._generator, self._parameters = space, generator, parameters

    def propose(self) -> list[Parameters]:
        """Independent draws."""
        return [sample(self._space, self._generator) for _ in range(self._parameters.batch)]

    def learn(self, trials: Sequence[Trial]) -> None:
        """Nothing is learned."""
