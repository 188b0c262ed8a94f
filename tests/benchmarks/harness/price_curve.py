"""Curves of what a method fixes over what it costs, as its settings go from timid to busy, and the best at a price."""

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

from rich.progress import Progress

from harness.contenders import BenchmarkPlan, resolve
from harness.grid import CHOICE_SEED, TABLE_SEED, Figures, Setting, alone, drive_all, drive_trials, random_drives
from harness.policy_benchmarks import select
from roadmend.measures.case_result import CaseResult
from roadmend.measures.evaluation_figures import cases_of
from roadmend.measures.repair import advantage
from roadmend.world.corpus import corpus_of
from roadmend.world.families import FAMILIES
from roadmend.world.scenario import Scenario

PRICES = (1, 2, 5)  # [%] of time lost at which the best setting is looked for
_SEPARATOR = " | "  # between a method's name and a setting's number in a title


@dataclass(frozen=True)
class Ground:
    """Where settings are driven: cases of a corpus, and random drives."""

    policy: str
    cases: tuple[Scenario, ...]
    drives: tuple[Scenario, ...]

    @classmethod
    def choosing(cls, policy: str, count: int, most: int) -> Self:
        """Validation cases, at most so many violations and successes of each family, and random drives of their own.

        Raises:
            InputError: the policy has no corpus.
        """
        return cls(policy, _cases(policy, "validation", most), tuple(random_drives(count, CHOICE_SEED)))

    @classmethod
    def showing(cls, policy: str, count: int, most: int | None) -> Self:
        """The test cases, perhaps at most so many violations and successes of each family, and the table's drives.

        Raises:
            InputError: the policy has no corpus.
        """
        return cls(policy, _cases(policy, "test", most), tuple(random_drives(count, TABLE_SEED)))

    def drive(
        self, settings: Sequence[Setting], work: Path, workers: int, progress: Progress, what: str
    ) -> tuple[Figures, Figures]:
        """Figures of the cases and of the random drives.

        Raises:
            InputError: the folder cannot be written.
            RoadmendError: an episode could not be driven.
            SimulationError: a worker process died.
        """
        everybody = [alone(self.policy), *settings]
        found = [
            drive_all(
                [trial for setting in everybody for trial in setting.trials(scenarios)],
                work,
                workers,
                progress,
                f"{self.policy}: {what}, {kind}",
            )
            for kind, scenarios in (("cases", self.cases), ("drives", self.drives))
        ]
        return found[0], found[1]

    def case_results(
        self, settings: Sequence[Setting], work: Path, workers: int, progress: Progress
    ) -> dict[str, list[CaseResult]]:
        """By each setting's title, what it comes to in the cases; what ``drive`` drove is not driven again.

        Raises:
            InputError: the folder cannot be written.
            RoadmendError: an episode could not be driven.
            SimulationError: a worker process died.
        """
        everybody = [alone(self.policy), *settings]
        trials = [trial for setting in everybody for trial in setting.trials(self.cases)]
        return cases_of(drive_trials(trials, work, workers, progress, f"{self.policy}: pairs"))[self.policy]


def _cases(policy: str, split: str, most: int | None) -> tuple[Scenario, ...]:
    return tuple(case.scenario() for case in select(corpus_of(policy), [*FAMILIES], most, split))


def curve_settings(plan: BenchmarkPlan, config: Path, policy: str, only: Sequence[str] | None) -> list[Setting]:
    """The settings of every curve of the plan, perhaps of some methods only.

    Raises:
        InputError: a parameter is unusable.
    """
    settings = []
    for curve in plan.curves:
        contenders, _ = resolve(plan, config, policy, [curve.method])
        if only is not None and curve.method not in only:
            continue
        for contender in contenders:
            settings += [
                Setting(
                    f"{contender.name}{_SEPARATOR}{number}",
                    policy,
                    contender.method,
                    {**contender.parameters, **values},
                    contender.describe(),
                )
                for number, values in enumerate(_combinations(curve.values))
            ]
    return settings


def points_of(settings: Sequence[Setting], figures: tuple[Figures, Figures]) -> dict[str, list[dict[str, Any]]]:
    """The points of each method's curve, by time lost."""
    curves: dict[str, list[dict[str, Any]]] = {}
    for setting in settings:
        curves.setdefault(setting.title.split(_SEPARATOR)[0], []).append(_point(setting, figures))
    for points in curves.values():
        points.sort(key=lambda point: point["time_lost"])
    return curves


def at_time_lost(
    curves: Mapping[str, Sequence[Mapping[str, Any]]],
    settings: Sequence[Setting],
    shown: Ground,
    drive: Callable[[Ground, Sequence[Setting]], tuple[Figures, Figures]],
) -> dict[str, dict[str, Any]]:
    """Of each method and price, the setting that was best where settings are chosen, and what it comes to where shown.

    A price that no setting keeps to has none.

    Args:
        curves: points of each method.
        settings: of which the points are.
        shown: where the chosen ones are driven.
        drive: does that.
    """
    known = {setting.title: setting for setting in settings}
    chosen: dict[tuple[str, int], Mapping[str, Any]] = {}
    for method, points in curves.items():
        for price in PRICES:
            cheap = [point for point in points if point["time_lost"] <= price]
            if cheap:
                chosen[method, price] = max(cheap, key=lambda point: point["delta_e"])
    figures = drive(shown, [known[title] for title in dict.fromkeys(point["setting"] for point in chosen.values())])
    found: dict[str, dict[str, Any]] = {method: {str(price): None for price in PRICES} for method in curves}
    for (method, price), point in chosen.items():
        found[method][str(price)] = {**_point(known[point["setting"]], figures), "chosen_at": dict(point)}
    return found


def add_leads(
    found: Mapping[str, Mapping[str, dict[str, Any] | None]], results: Mapping[str, Sequence[CaseResult]]
) -> None:
    """Write into every chosen point, as "lead", by how much ADReFT's at the same price fixes more, paired by case.

    Args:
        found: by ``at_time_lost``.
        results: of the cases, by the setting's title.
    """
    for prices in found.values():
        for price, point in prices.items():
            own = found.get("adreft", {}).get(price)
            if point is not None:
                point["lead"] = None if own is None else _lead(results[own["setting"]], results[point["setting"]])


def _lead(own: Sequence[CaseResult], other: Sequence[CaseResult]) -> dict[str, Any]:
    more = advantage(own, other)
    return {"delta_e": more["delta_e"], "interval": more["intervals"]["delta_e"]}


def _point(setting: Setting, figures: tuple[Figures, Figures]) -> dict[str, Any]:
    cases, drives = (found[setting.policy][setting.title] for found in figures)
    repair, ordinary = cases["repair"], drives["ordinary"]
    parameters = {name: value for name, value in setting.parameters.items() if name != "model"}
    return {
        "setting": setting.title,
        "method": setting.method,
        "parameters": parameters,
        "contender": {**setting.contender, "parameters": parameters},
        "violations": repair["violations"],
        "successes": repair["successes"],
        "fix": repair["fix"],
        "deg": repair["deg"],
        "delta_e": repair["delta_e"],
        "interval": repair["intervals"]["delta_e"],
        "dose": repair["dose"],
        "time_lost": ordinary["time_lost"],
        "untouched": ordinary["untouched"],
        "new_collisions": ordinary["new_collisions"],
    }


def _combinations(grids: Sequence[Mapping[str, Sequence[Any]]]) -> list[dict[str, Any]]:
    return [dict(zip(grid, values, strict=True)) for grid in grids for values in itertools.product(*grid.values())]
