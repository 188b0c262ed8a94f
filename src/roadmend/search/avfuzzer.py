"""AV-Fuzzer (Li et al., ISSRE 2020): genetic search with local fuzzing and restarts.

As in the paper: tournament selection, crossover, mutation, a local search around what is promising, and a restart far
from earlier populations once the best no longer improves. Ours: the chromosome is the whole parameter space of a
family instead of the other vehicles' manoeuvres, and a search goes on after its first violation.
"""

import random
from collections.abc import Sequence
from enum import Enum, auto

from pydantic import Field

from roadmend.search.evaluation import Trial
from roadmend.search.moves import cross, distance, mutate
from roadmend.search.technique import TechniqueParameters
from roadmend.world.space import Parameters, Space, sample


class AvFuzzerParameters(TechniqueParameters):
    """What can be set."""

    population: int = Field(12, ge=2, le=1000, description="individuals of a generation")
    tournament: int = Field(3, ge=1, le=100, description="individuals among which a parent is the fittest")
    crossover: float = Field(0.6, ge=0.0, le=1.0, description="probability that a child has two parents")
    mutation_rate: float = Field(0.06, gt=0.0, le=1.0, description="probability that a dimension of a child is moved")
    mutation_strength: float = Field(0.25, gt=0.0, le=1.0, description="deviation of a move, share of the range")
    local_size: int = Field(6, ge=1, le=1000, description="points tried around an individual that has become the best")
    local_rate: float = Field(0.03, gt=0.0, le=1.0, description="mutation rate around it")
    local_strength: float = Field(0.08, gt=0.0, le=1.0, description="mutation strength around it")
    promising: float = Field(
        -6.0, ge=-100.0, le=0.0, description="least fitness of a new best individual that is fuzzed locally [m]"
    )
    patience: int = Field(3, ge=1, le=1000, description="generations without a better best before a restart")
    candidates: int = Field(60, ge=1, le=10_000, description="draws from which a restart takes the farthest")


class _Phase(Enum):
    START = auto()  # a new population
    BREED = auto()  # the next generation
    LOCAL = auto()  # around the best


class AvFuzzer:
    """One population at a time; earlier ones are remembered as places to stay away from."""

    def __init__(self, space: Space, generator: random.Random, parameters: AvFuzzerParameters) -> None:
        self._space, self._generator, self._parameters = space, generator, parameters
        self._phase = _Phase.START
        self._population: list[Trial] = []  # fittest first
        self._left: list[Parameters] = []  # the best of each earlier population
        self._stale = 0  # generations since the best became better
        self.restarts = 0

    def propose(self) -> list[Parameters]:
        """A new population, its next generation or the surroundings of its best."""
        own = self._parameters
        match self._phase:
            case _Phase.START:
                return self._start()
            case _Phase.BREED:
                return [self._child() for _ in range(own.population)]
            case _Phase.LOCAL:
                best = self._population[0].parameters
                return [
                    mutate(self._space, best, own.local_rate, own.local_strength, self._generator)
                    for _ in range(own.local_size)
                ]

    def learn(self, trials: Sequence[Trial]) -> None:
        """Keep the fittest of parents and children, and decide what comes next."""
        own, before = self._parameters, self._population
        ranked = sorted([*before, *trials], key=lambda trial: -trial.fitness)  # stable: parents stay before equals
        self._population = ranked[: own.population]
        best = ranked[0].fitness
        if self._phase is _Phase.START:
            self._phase, self._stale = _Phase.BREED, 0
            return
        improved = best > before[0].fitness
        if improved:
            self._stale = 0
        elif self._phase is _Phase.BREED:
            self._stale += 1
        if self._stale >= own.patience:
            self._left.append(ranked[0].parameters)
            self._population = []
            self._phase = _Phase.START
            self.restarts += 1
        elif improved and self._phase is _Phase.BREED and best >= own.promising:
            self._phase = _Phase.LOCAL
        else:
            self._phase = _Phase.BREED

    def _start(self) -> list[Parameters]:
        own = self._parameters
        if not self._left:
            return [sample(self._space, self._generator) for _ in range(own.population)]
        drawn = [sample(self._space, self._generator) for _ in range(max(own.candidates, own.population))]
        drawn.sort(key=lambda point: -min(distance(self._space, point, left) for left in self._left))
        return drawn[: own.population]

    def _child(self) -> Parameters:
        own = self._parameters
        child = self._parent()
        if self._generator.random() < own.crossover:
            child = cross(self._space, child, self._parent(), self._generator)
        return mutate(self._space, child, own.mutation_rate, own.mutation_strength, self._generator)

    def _parent(self) -> Parameters:
        drawn = [self._generator.choice(self._population) for _ in range(self._parameters.tournament)]
        return max(drawn, key=lambda trial: trial.fitness).parameters
