"""Which points of a search become cases: spread over its evaluations, each a different episode, none too alike."""

from collections.abc import Container, Sequence
from dataclasses import dataclass, field
from typing import TypeVar

from roadmend.search.evaluation import Trial
from roadmend.search.moves import distance
from roadmend.world.space import Parameters, Space

Item = TypeVar("Item")


def spread(items: Sequence[Item], count: int) -> list[Item]:
    """All items in another order: first ``count`` at even steps, then the rest as they were."""
    count = min(count, len(items))
    first = [(2 * number + 1) * len(items) // (2 * count) for number in range(count)]
    taken = set(first)
    return [items[index] for index in first] + [item for index, item in enumerate(items) if index not in taken]


def shares(total: int, available: Sequence[int]) -> list[int]:
    """How many to take from each source: as evenly as what they have allows, earlier ones first."""
    taken = [0] * len(available)
    left = min(total, sum(available))
    while left:
        open_sources = [index for index, most in enumerate(available) if taken[index] < most]
        each = max(1, left // len(open_sources))
        for index in open_sources:
            step = min(each, available[index] - taken[index], left)
            taken[index] += step
            left -= step
    return taken


@dataclass
class Picker:
    """Takes points of one search."""

    space: Space
    least_distance: float  # between any two taken
    known: Container[str]  # digests of trajectories that are taken elsewhere
    _points: list[Parameters] = field(default_factory=list)
    _digests: set[str] = field(default_factory=set)

    def pick(self, trials: Sequence[tuple[int, Trial]], count: int) -> list[tuple[int, Trial]]:
        """Take up to ``count`` of the trials given, in the order of their index."""
        picked: list[tuple[int, Trial]] = []
        for index, trial in spread(trials, count):
            if len(picked) == count:
                break
            digest = trial.evaluation.digest
            if digest in self._digests or digest in self.known:
                continue
            if any(distance(self.space, trial.parameters, point) < self.least_distance for point in self._points):
                continue
            self._points.append(trial.parameters)
            self._digests.add(digest)
            picked.append((index, trial))
        return sorted(picked, key=lambda pair: pair[0])
