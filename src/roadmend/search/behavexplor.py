"""BehAVExplor (Cheng et al., ISSTA 2023): a corpus of seeds that is fed by new behaviour and by nearness to violations.

As in the paper: behaviours are clustered, a mutant joins the corpus if its behaviour is new or it came nearer to a
violation than its seed, violations themselves do not; seeds are picked by energy, which rewards what their mutants
brought; seeds near a violation are mutated a little, others a lot. Ours: leader clustering over resampled motion.
"""

import math
import random
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from roadmend.search.evaluation import Trial
from roadmend.search.moves import mutate
from roadmend.search.technique import TechniqueParameters
from roadmend.world.space import Parameters, Space, sample

_LEAST, _MOST = 0.01, 3.0  # bounds that keep every seed in play and none in all


class BehAVExplorParameters(TechniqueParameters):
    """What can be set."""

    initial: int = Field(24, ge=1, le=10_000, description="random points that the corpus starts from")
    batch: int = Field(8, ge=1, le=1000, description="mutants evaluated side by side")
    corpus: int = Field(200, ge=1, le=100_000, description="seeds kept; those of least energy are dropped")
    radius: float = Field(0.15, gt=0.0, le=10.0, description="feature difference within which behaviours are alike")
    novelty: float = Field(0.6, ge=0.0, le=1.0, description="share of the radius from which a behaviour is new")
    diversity_weight: float = Field(1.0, ge=0.0, le=100.0, description="energy for the newest behaviour")
    violation_weight: float = Field(2.0, ge=0.0, le=100.0, description="energy for the nearest miss")
    violation_scale: float = Field(
        4.0, gt=0.0, le=100.0, description="fitness by which a seed with 1/e of it lags behind [m]"
    )
    decay: float = Field(0.8, gt=0.0, le=1.0, description="factor on a seed's energy for a mutant in vain")
    rate: float = Field(0.1, gt=0.0, le=1.0, description="probability that a dimension of a mutant is moved")
    least_strength: float = Field(0.1, gt=0.0, le=1.0, description="mutation strength of the nearest miss")
    most_strength: float = Field(0.4, gt=0.0, le=1.0, description="mutation strength far from violations")


class LeaderClusters:
    """Clusters without a number to choose: a behaviour joins the nearest cluster within ``radius`` of its centre, or founds a new one."""

    def __init__(self, radius: float) -> None:
        """Start without clusters.

        Args:
            radius: root-mean-square difference of the features within which behaviours count as alike.
        """
        self._radius = radius
        self._centres: list[NDArray[np.float64]] = []
        self.counts: list[int] = []  # members of each cluster

    def __len__(self) -> int:
        return len(self._centres)

    def nearest(self, features: Sequence[float]) -> tuple[int, float]:
        """The nearest cluster and the distance to its centre; (-1, infinity) where there is none."""
        if not self._centres:
            return -1, float("inf")
        apart = np.sqrt(np.mean((np.array(self._centres) - np.asarray(features)) ** 2, axis=1))
        index = int(np.argmin(apart))
        return index, float(apart[index])

    def add(self, features: Sequence[float]) -> tuple[int, float]:
        """Count a behaviour in.

        Returns:
            Its cluster, and how new it was: distance to the nearest centre in radii, at most 1; 1 founds a cluster.
        """
        index, apart = self.nearest(features)
        if apart > self._radius:
            self._centres.append(np.array(features, dtype=np.float64))
            self.counts.append(1)
            return len(self._centres) - 1, 1.0
        self.counts[index] += 1
        self._centres[index] += (np.asarray(features) - self._centres[index]) / self.counts[index]
        return index, apart / self._radius


@dataclass(slots=True)
class _Seed:
    parameters: Parameters
    fitness: float
    novelty: float  # of its behaviour when it came, 0 to 1
    yielding: float = 1.0  # factor on its energy: grows with mutants that brought something, shrinks with others


class BehAVExplor:
    """A fuzzer over one corpus."""

    def __init__(self, space: Space, generator: random.Random, parameters: BehAVExplorParameters) -> None:
        self._space, self._generator, self._parameters = space, generator, parameters
        self._clusters = LeaderClusters(parameters.radius)
        self._corpus: list[_Seed] = []
        self._nearest = 0.0  # fitness of the nearest miss in the corpus
        self._picked: list[_Seed] = []  # the seed of each mutant of the batch; none while the corpus is empty

    def propose(self) -> list[Parameters]:
        """Random points while there is no corpus, then mutants of its seeds."""
        own = self._parameters
        if not self._corpus:
            self._picked = []
            return [sample(self._space, self._generator) for _ in range(own.initial)]
        weights = [self._energy(seed) for seed in self._corpus]
        self._picked = self._generator.choices(self._corpus, weights, k=own.batch)
        return [self._mutant(seed) for seed in self._picked]

    def learn(self, trials: Sequence[Trial]) -> None:
        """Cluster the behaviours, judge the seeds by what their mutants brought, and take in new seeds."""
        own = self._parameters
        seeds: Sequence[_Seed | None] = self._picked or [None] * len(trials)
        for trial, seed in zip(trials, seeds, strict=True):
            if not trial.evaluation.digest:
                continue  # a crash has no behaviour
            _, novelty = self._clusters.add(trial.evaluation.features)
            useful = seed is None or novelty >= own.novelty or trial.fitness > seed.fitness
            if seed is not None:
                seed.yielding = (
                    min(_MOST, seed.yielding / own.decay) if useful else max(_LEAST, seed.yielding * own.decay)
                )
            if useful and not trial.evaluation.is_violation:
                self._corpus.append(_Seed(trial.parameters, trial.fitness, novelty))
        self._nearest = max((seed.fitness for seed in self._corpus), default=0.0)
        self._corpus.sort(key=lambda seed: -self._energy(seed))
        del self._corpus[own.corpus :]

    def _degree(self, seed: _Seed) -> float:
        """Nearness to a violation in (0, 1]; 1 for the nearest miss in the corpus."""
        return math.exp((seed.fitness - self._nearest) / self._parameters.violation_scale)

    def _energy(self, seed: _Seed) -> float:
        own = self._parameters
        merit = own.diversity_weight * seed.novelty + own.violation_weight * self._degree(seed)
        return max(_LEAST, merit) * seed.yielding

    def _mutant(self, seed: _Seed) -> Parameters:
        own = self._parameters
        strength = own.most_strength + (own.least_strength - own.most_strength) * self._degree(seed)
        return mutate(self._space, seed.parameters, own.rate, strength, self._generator)
