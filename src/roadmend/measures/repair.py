"""From results of cases to the figures of a repair method (ADReFT section 4, metrics)."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from roadmend.measures.case_result import CaseResult
from roadmend.measures.intervals import bootstrap, by_group, newcombe, wilson
from roadmend.world.case_name import search_of

Floats = NDArray[np.float64]
Figures = dict[str, Any]
Value = TypeVar("Value", float, Floats)


@dataclass(frozen=True, slots=True)
class PairedCase:
    """What is needed of a case to hold two methods against each other, and for the intervals of one."""

    case: str
    is_violation: bool
    reached_goal: bool
    collided: bool
    dose: float  # [s]
    timed_out: bool = False
    change: float = 0.0  # of the action, summed over frames
    frames: int = 0  # that were changed

    @classmethod
    def of(cls, result: CaseResult) -> "PairedCase":
        """That of a whole result."""
        episode = result.episode
        return cls(
            result.case,
            result.is_violation,
            episode.reached_goal,
            episode.collided,
            episode.dose,
            episode.timed_out,
            episode.change,
            episode.interventions,
        )


@dataclass(frozen=True, slots=True)
class Split:
    """Results of one method, apart by what the policy alone does."""

    violations: tuple[CaseResult, ...]
    successes: tuple[CaseResult, ...]

    @classmethod
    def of(cls, results: Sequence[CaseResult]) -> "Split":
        """Part the results."""
        violations = tuple(result for result in results if result.is_violation)
        return cls(violations, tuple(result for result in results if not result.is_violation))

    @property
    def fixed(self) -> int:
        """Violations that now end at the goal."""
        return sum(result.episode.reached_goal for result in self.violations)

    @property
    def unharmed(self) -> int:
        """Violations that no longer end in a collision."""
        return sum(not result.episode.collided for result in self.violations)

    @property
    def stopped(self) -> int:
        """Violations that now end by the time limit."""
        return sum(result.episode.timed_out for result in self.violations)

    @property
    def degraded(self) -> int:
        """Successes that now end in a collision."""
        return sum(result.episode.collided for result in self.successes)

    @property
    def lost(self) -> int:
        """Successes that no longer end at the goal."""
        return sum(not result.episode.reached_goal for result in self.successes)


def figures_of(results: Sequence[CaseResult]) -> Figures:
    """Figures of one method over some cases; shares in percent, None where there is nothing to count.

    ``fix``: violations that now end at the goal; ``fix_loose``: that no longer end in a collision (the paper's count);
    ``deg``: successes that now end in a collision; ``delta_e`` = fix - deg; ``stopped``: violations that now end by
    the time limit, and no fix for that; ``goal_lost``: successes that no longer end at the goal, for any reason.
    ``intensity``: mean |policy's action - final action|, 0 .. 2, over all replaced frames of all cases pooled.
    ``dose`` [s] and ``intervened_frames``: means a case. ``peak_deceleration`` [m/s2], ``peak_jerk`` [m/s3]: means of
    the cases' peaks.
    """
    split = Split.of(results)
    violations, successes = split.violations, split.successes
    frames = sum(result.episode.interventions for result in results)
    total = len(results)
    fix, fix_loose = _percent(split.fixed, len(violations)), _percent(split.unharmed, len(violations))
    deg = _percent(split.degraded, len(successes))
    return {
        "violations": len(violations),
        "successes": len(successes),
        "fix": fix,
        "deg": deg,
        "delta_e": None if fix is None or deg is None else delta_e(fix, deg),
        "intensity": _ratio(_sum(result.episode.change for result in results), frames),
        "dose": _ratio(_sum(result.episode.dose for result in results), total),
        "dose_violations": _ratio(_sum(result.episode.dose for result in violations), len(violations)),
        "dose_successes": _ratio(_sum(result.episode.dose for result in successes), len(successes)),
        "intervened_frames": _ratio(frames, total),
        "fix_loose": fix_loose,
        "delta_e_loose": None if fix_loose is None or deg is None else delta_e(fix_loose, deg),
        "stopped": _percent(split.stopped, len(violations)),
        "goal_lost": _percent(split.lost, len(successes)),
        "untouched": _percent(sum(result.episode.interventions == 0 for result in successes), len(successes)),
        "peak_deceleration": _ratio(_sum(result.episode.peak_deceleration for result in results), total),
        "peak_jerk": _ratio(_sum(result.episode.peak_jerk for result in results), total),
    }


def delta_e(fix: Value, deg: Value) -> Value:
    """The paper's first figure: violations that are repaired less successes that are spoilt, both as shares of them."""
    return fix - deg


def summarise(results: Sequence[CaseResult]) -> Figures:
    """The figures with their 95 % intervals in ``intervals``."""
    return figures_of(results) | {"intervals": intervals_of([*map(PairedCase.of, results)])}


def intervals_of(cases: Sequence[PairedCase]) -> dict[str, list[float] | None]:
    """The 95 % intervals of a method's figures.

    ``share_interval`` for shares, ``delta_e_interval`` for delta_e, the bootstrap over searches, drawn within violations
    and successes, for the rest; that is None where all violations, and all successes, are of one search.
    """
    violations = [case for case in cases if case.is_violation]
    successes = [case for case in cases if not case.is_violation]
    return {
        "fix": share_interval([(each.case, each.reached_goal) for each in violations]),
        "deg": share_interval([(each.case, each.collided) for each in successes]),
        "delta_e": delta_e_interval(cases),
        "fix_loose": share_interval([(each.case, not each.collided) for each in violations]),
        "stopped": share_interval([(each.case, each.timed_out) for each in violations]),
        "goal_lost": share_interval([(each.case, not each.reached_goal) for each in successes]),
        **_bootstraps(cases),
    }


def share_interval(cases: Sequence[tuple[str, bool]]) -> list[float] | None:
    """The 95 % interval of a share of cases, in percent; None without cases.

    On each side the wider one of Wilson's, which takes cases as independent, and of the bootstrap over searches.

    Args:
        cases: names, and whether each counts.
    """
    if not cases:
        return None
    low, high = wilson(sum(counts for _, counts in cases), len(cases))
    sums = by_group(np.array([(counts, 1.0) for _, counts in cases]), [search_of(name) for name, _ in cases])
    other_low, other_high = bootstrap((sums,), lambda drawn: _shares(drawn[0]))
    return _bounds((min(low, other_low), max(high, other_high)), 100.0)


def delta_e_interval(cases: Sequence[PairedCase]) -> list[float] | None:
    """The 95 % interval of ``delta_e``; None without violations or without successes.

    On each side the wider one of Newcombe's, which takes cases as independent, and of the bootstrap over searches, which
    is certain of a method that repairs everything.
    """
    fixed = [case.reached_goal for case in cases if case.is_violation]
    spoilt = [case.collided for case in cases if not case.is_violation]
    if not fixed or not spoilt:
        return None
    low, high = newcombe(sum(fixed), len(fixed), sum(spoilt), len(spoilt))
    violations, successes = _by_search(
        cases, [(case.reached_goal if case.is_violation else case.collided, 1.0) for case in cases]
    )
    other_low, other_high = bootstrap((violations, successes), lambda sums: delta_e(*(_shares(each) for each in sums)))
    return _bounds((min(low, other_low), max(high, other_high)), 100.0)


def advantage(results: Sequence[CaseResult], others: Sequence[CaseResult]) -> Figures:
    """As ``advantage_of``, of whole results.

    Raises:
        ValueError: the two were not run on the same cases.
    """
    return advantage_of([*map(PairedCase.of, results)], [*map(PairedCase.of, others)])


def advantage_of(results: Sequence[PairedCase], others: Sequence[PairedCase]) -> Figures:
    """By how much ``delta_e`` and ``dose`` of a method exceed another's on the same cases.

    With the intervals of the paired bootstrap: searches are drawn, and both methods are read on their cases; None where
    all violations, or all successes, are of one search.

    Raises:
        ValueError: the two were not run on the same cases.
    """
    if [result.case for result in results] != [other.case for other in others]:
        raise ValueError("results of different cases cannot be paired")
    pairs = list(zip(results, others, strict=True))
    strata = _by_search(
        results,
        [
            (a.reached_goal - b.reached_goal if a.is_violation else a.collided - b.collided, 1.0, a.dose - b.dose)
            for a, b in pairs
        ],
    )

    def difference(sums: tuple[Floats, ...]) -> Floats:
        return 100.0 * delta_e(_shares(sums[0]), _shares(sums[1]))

    def dose(sums: tuple[Floats, ...]) -> Floats:
        return (sums[0][:, 2] + sums[1][:, 2]) / np.maximum(1.0, sums[0][:, 1] + sums[1][:, 1])

    whole = tuple(table.sum(axis=0, keepdims=True) for table in strata)
    can_vary = all(len(table) > 1 for table in strata)
    return {
        "delta_e": _finite(float(difference(whole)[0])),
        "dose": _finite(float(dose(whole)[0])),
        "intervals": {
            "delta_e": _bounds(bootstrap(strata, difference), 1.0) if can_vary else None,
            "dose": _bounds(bootstrap(strata, dose), 1.0) if can_vary else None,
        },
    }


def _by_search(cases: Sequence[PairedCase], rows: Sequence[Sequence[float]]) -> tuple[Floats, Floats]:
    """Rows of cases, added up by search: those of violations and those of successes."""
    table = np.array(rows, dtype=np.float64).reshape(len(rows), -1)
    chosen = np.array([case.is_violation for case in cases], dtype=np.bool_)
    searches = np.array([search_of(case.case) for case in cases], dtype=object)
    violations, successes = (by_group(table[each], list(searches[each])) for each in (chosen, ~chosen))
    return violations, successes


def _shares(sums: Floats) -> Floats:
    """Of sums and counts, shape (n, 2 or more); NaN where nothing was counted."""
    return np.where(sums[:, 1] > 0.0, sums[:, 0] / np.maximum(sums[:, 1], 1.0), math.nan)


def share_of_bound(results: Sequence[CaseResult], bound: Mapping[str, CaseResult]) -> Figures:
    """A method against the hindsight bound, on the violations for which there is one.

    Args:
        results: of the method.
        bound: by case, the least intervention known that reaches the goal; or the best attempt where none does.

    Returns:
        ``repairable``: violations that the bound repairs. ``fix_share``: percent of those that the method fixes.
        ``dose_ratio``: dose of the method over dose of the bound on the violations that both repair, sums of both;
        ``dose_ratio_all``: the same on all that the bound repairs, fixed by the method or not.
    """
    pairs = [(result, bound[result.case]) for result in results if result.is_violation and result.case in bound]
    pairs = [(result, best) for result, best in pairs if best.episode.reached_goal]
    both = [(result, best) for result, best in pairs if result.episode.reached_goal]
    return {
        "repairable": len(pairs),
        "fix_share": _percent(len(both), len(pairs)),
        "dose_ratio": _ratio(
            _sum(result.episode.dose for result, _ in both), _sum(best.episode.dose for _, best in both)
        ),
        "dose_ratio_all": _ratio(
            _sum(result.episode.dose for result, _ in pairs), _sum(best.episode.dose for _, best in pairs)
        ),
    }


def _bootstraps(cases: Sequence[PairedCase]) -> dict[str, list[float] | None]:
    if not cases:
        return dict.fromkeys(("intensity", "dose", "intervened_frames"))
    rows = [(case.dose, 1.0, case.change, case.frames) for case in cases]
    tables = _by_search(cases, rows)
    if all(len(table) < 2 for table in tables):  # nothing can be drawn but what there is
        return dict.fromkeys(("intensity", "dose", "intervened_frames"))

    def share_of(column: int, whole: int) -> list[float] | None:
        def statistic(sums: tuple[Floats, ...]) -> Floats:
            value, of = (sums[0][:, place] + sums[1][:, place] for place in (column, whole))
            return np.where(of > 0.0, value / np.maximum(of, 1.0), math.nan)

        return _bounds(bootstrap(tables, statistic), 1.0)

    return {"intensity": share_of(2, 3), "dose": share_of(0, 1), "intervened_frames": share_of(3, 1)}


def _sum(values: Any) -> float:
    """Exact, so that it does not depend on the order."""
    return math.fsum(values)


def _ratio(value: float, by: float) -> float | None:
    return value / by if by else None


def _percent(count: int, trials: int) -> float | None:
    return 100.0 * count / trials if trials else None


def _bounds(interval: tuple[float, float], factor: float) -> list[float] | None:
    low, high = interval
    return [factor * low, factor * high] if math.isfinite(low) and math.isfinite(high) else None


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
