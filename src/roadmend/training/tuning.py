"""Gives each rival its own best setting, found in closed loop on the validation split.

Two rounds: every setting drives a part of the cases, then the best few drive all of them. The best has the largest dE;
of equals the one with the least intensity, of equals again the one that stands first in the grid.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from roadmend.core.errors import InputError
from roadmend.core.fanout import Mapper
from roadmend.core.journal import Journal, Key, entry_key
from roadmend.measures.case_result import CaseResult
from roadmend.measures.driver import driver_key
from roadmend.training.closed_loop import EpisodeCase, Summary, evaluate_cases, summarise
from roadmend.training.tuning_grid import Rival, Values
from roadmend.world.scenario_file import outside_content

FORMAT = "roadmend-tuning/1"
EPISODES = "roadmend-tuning-episodes/1"
PART = 3  # the first round drives every so many-th case of each family and kind
FINALISTS = 4  # settings that drive all cases


@dataclass(frozen=True, slots=True)
class Point:
    """A setting and what it came to."""

    parameters: Values
    first: Summary  # on a part of the cases
    whole: Summary | None  # on all of them; none for those that the first round left behind

    @property
    def is_finalist(self) -> bool:
        """Whether it has driven all cases."""
        return self.whole is not None


@dataclass(frozen=True, slots=True)
class TunedRival:
    """A rival's grid and the best of it."""

    name: str
    method: str
    points: tuple[Point, ...]
    best: int  # index into ``points``

    @property
    def chosen(self) -> Point:
        """The best setting."""
        return self.points[self.best]

    def dump(self) -> dict[str, Any]:
        """As plain values: what was chosen, and the whole grid with its figures."""
        return {
            "method": self.method,
            "parameters": dict(self.chosen.parameters),
            "figures": _figures(self.chosen.whole),
            "grid": [
                {"parameters": dict(point.parameters), "part": _figures(point.first), "all": _figures(point.whole)}
                for point in self.points
            ],
        }


def worth(summary: Summary) -> tuple[float, float]:
    """The larger, the better: dE, then the intensity turned round."""
    return round(summary.delta_e, 9), -summary.intensity


def part_of(cases: Sequence[EpisodeCase]) -> list[EpisodeCase]:
    """Every PART-th case of each family and kind, the first one included, in the order of the cases."""
    seen: dict[tuple[str, bool], int] = {}
    chosen: list[EpisodeCase] = []
    for case in cases:
        key = case.family, case.is_violation
        if seen.get(key, 0) % PART == 0:
            chosen.append(case)
        seen[key] = seen.get(key, 0) + 1
    return chosen


class Tuning:
    """Drives settings on cases, each pair at most once: what was driven before an interruption is in the journal."""

    def __init__(
        self,
        cases: Sequence[EpisodeCase],
        policy: str,
        journal: Journal,
        mapper: Mapper,
        report: Callable[[str, int, int], None] = lambda _rival, _done, _total: None,
    ) -> None:
        """Prepare.

        Args:
            cases: of the validation split; with violations and successes.
            policy: name of the policy in the loop.
            journal: of the episodes.
            mapper: runs episodes side by side.
            report: called with the rival, the episodes driven and how many there are in this round.

        Raises:
            InputError: a kind of case is missing.
        """
        for wanted, word in ((True, "violation"), (False, "success")):
            if not any(case.is_violation == wanted for case in cases):
                raise InputError("validation split", f"has no {word}", "give a corpus with both in it")
        self._cases, self._policy, self._journal = list(cases), policy, journal
        scenarios = {case.name: case.scenario() for case in cases}
        self._scenarios = {name: (each.digest, outside_content(each)) for name, each in scenarios.items()}
        self._mapper, self._report = mapper, report

    def tune(self, rival: Rival) -> TunedRival:
        """Find a rival's best setting.

        Raises:
            InputError: a parameter or a scenario is unusable.
            SimulationError: SUMO failed, or a worker process died.
        """
        part = part_of(self._cases)
        first = self._drive(rival, rival.grid, part)
        ranked = sorted(range(len(first)), key=lambda index: worth(first[index]), reverse=True)
        finalists = ranked[:FINALISTS]
        driven = self._drive(rival, [rival.grid[index] for index in finalists], self._cases)
        whole = dict(zip(finalists, driven, strict=True))
        best = max(sorted(whole), key=lambda index: worth(whole[index]))
        points = (Point(parameters, first[index], whole.get(index)) for index, parameters in enumerate(rival.grid))
        return TunedRival(rival.name, rival.method, tuple(points), best)

    def _drive(self, rival: Rival, grid: Sequence[Values], cases: Sequence[EpisodeCase]) -> list[Summary]:
        """One summary a setting."""
        drivers = [driver_key(self._policy, rival.method, parameters) for parameters in grid]
        keys = [
            [entry_key([__name__], driver, case.name, self._scenarios[case.name]) for case in cases]
            for driver in drivers
        ]
        missing = [
            (key, (parameters, case))
            for parameters, row in zip(grid, keys, strict=True)
            for key, case in zip(row, cases, strict=True)
            if self._journal.get(key) is None
        ]
        total = len(grid) * len(cases)
        done = total - len(missing)
        self._report(rival.name, done, total)
        results = self._mapper(
            partial(_evaluate, policy=self._policy, method=rival.method), [question for _, question in missing]
        )
        for (key, _), result in zip(missing, results, strict=True):
            self._journal.add(key, result.dump())
            done += 1
            self._report(rival.name, done, total)
        return [summarise([self._result(key) for key in row]) for row in keys]

    def _result(self, key: Key) -> CaseResult:
        try:
            return CaseResult.parse(self._journal.get(key) or {})
        except ValueError:
            raise InputError(str(self._journal.path), "is damaged", "remove it") from None


def _evaluate(question: tuple[Values, EpisodeCase], *, policy: str, method: str) -> CaseResult:
    parameters, case = question
    return evaluate_cases([case], policy, method, parameters)[0]


def _figures(summary: Summary | None) -> dict[str, float] | None:
    return None if summary is None else {name: round(value, 4) for name, value in summary.as_dict().items()}
