"""From results of cases to the figures of a repair method (ADReFT section 4, metrics)."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from roadmend.measures.case_result import CaseResult
from roadmend.measures.intervals import bootstrap, newcombe, wilson

Floats = NDArray[np.float64]
Figures = dict[str, Any]
Value = TypeVar("Value", float, Floats)


@dataclass(frozen=True, slots=True)
class PairedCase:
    """What is needed of a case to hold two methods against each other."""

    case: str
    is_violation: bool
    reached_goal: bool
    collided: bool
    dose: float  # [s]

    @classmethod
    def of(cls, result: CaseResult) -> "PairedCase":
        """That of a whole result."""
        episode = result.episode
        return cls(result.case, result.is_violation, episode.reached_goal, episode.collided, episode.dose)


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
    """The figures with their 95 % intervals in ``intervals``.

    Wilson's for shares, Newcombe's for delta_e, the bootstrap over cases, drawn within violations and successes, for the
    rest.
    """
    split = Split.of(results)
    violations, successes = split.violations, split.successes
    figures = figures_of(results)
    figures["intervals"] = {
        "fix": _share_interval(split.fixed, len(violations)),
        "deg": _share_interval(split.degraded, len(successes)),
        "delta_e": _difference_interval(split.fixed, len(violations), split.degraded, len(successes)),
        "fix_loose": _share_interval(split.unharmed, len(violations)),
        "stopped": _share_interval(split.stopped, len(violations)),
        "goal_lost": _share_interval(split.lost, len(successes)),
        **_bootstraps(split),
    }
    return figures


def advantage(results: Sequence[CaseResult], others: Sequence[CaseResult]) -> Figures:
    """As ``advantage_of``, of whole results.

    Raises:
        ValueError: the two were not run on the same cases.
    """
    return advantage_of([*map(PairedCase.of, results)], [*map(PairedCase.of, others)])


def advantage_of(results: Sequence[PairedCase], others: Sequence[PairedCase]) -> Figures:
    """By how much ``delta_e`` and ``dose`` of a method exceed another's on the same cases.

    With the intervals of the paired bootstrap: cases are drawn, and both methods are read on what was drawn.

    Raises:
        ValueError: the two were not run on the same cases.
    """
    if [result.case for result in results] != [other.case for other in others]:
        raise ValueError("results of different cases cannot be paired")
    pairs = list(zip(results, others, strict=True))
    violations = np.array(
        [(a.reached_goal - b.reached_goal, a.dose - b.dose) for a, b in pairs if a.is_violation],
        dtype=np.float64,
    ).reshape(-1, 2)
    successes = np.array(
        [(a.collided - b.collided, a.dose - b.dose) for a, b in pairs if not a.is_violation],
        dtype=np.float64,
    ).reshape(-1, 2)
    strata = violations, successes

    def difference(sums: tuple[Floats, ...]) -> Floats:
        return 100.0 * delta_e(_share(sums[0][:, 0], len(violations)), _share(sums[1][:, 0], len(successes)))

    def dose(sums: tuple[Floats, ...]) -> Floats:
        return (sums[0][:, 1] + sums[1][:, 1]) / max(1, len(pairs))

    whole = violations.sum(axis=0, keepdims=True), successes.sum(axis=0, keepdims=True)
    return {
        "delta_e": _finite(float(difference(whole)[0])),
        "dose": _finite(float(dose(whole)[0])),
        "intervals": {
            "delta_e": _bounds(bootstrap(strata, difference), 1.0),
            "dose": _bounds(bootstrap(strata, dose), 1.0),
        },
    }


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


def _bootstraps(split: Split) -> dict[str, list[float] | None]:
    tables = tuple(
        np.array(
            [(each.episode.dose, each.episode.change, each.episode.interventions) for each in results], dtype=np.float64
        ).reshape(-1, 3)
        for results in (split.violations, split.successes)
    )
    cases = max(1, sum(len(table) for table in tables))

    def intensity(sums: tuple[Floats, ...]) -> Floats:
        frames = sums[0][:, 2] + sums[1][:, 2]
        return np.where(frames > 0.0, (sums[0][:, 1] + sums[1][:, 1]) / np.maximum(frames, 1.0), math.nan)

    def dose(sums: tuple[Floats, ...]) -> Floats:
        return (sums[0][:, 0] + sums[1][:, 0]) / cases

    def intervened(sums: tuple[Floats, ...]) -> Floats:
        return (sums[0][:, 2] + sums[1][:, 2]) / cases

    return {
        "intensity": _bounds(bootstrap(tables, intensity), 1.0),
        "dose": _bounds(bootstrap(tables, dose), 1.0),
        "intervened_frames": _bounds(bootstrap(tables, intervened), 1.0),
    }


def _sum(values: Any) -> float:
    """Exact, so that it does not depend on the order."""
    return math.fsum(values)


def _share(counts: Floats, trials: int) -> Floats:
    return counts / trials if trials else np.full(counts.shape, math.nan)


def _ratio(value: float, by: float) -> float | None:
    return value / by if by else None


def _percent(count: int, trials: int) -> float | None:
    return 100.0 * count / trials if trials else None


def _share_interval(count: int, trials: int) -> list[float] | None:
    return _bounds(wilson(count, trials), 100.0) if trials else None


def _difference_interval(count: int, trials: int, others: int, other_trials: int) -> list[float] | None:
    if not trials or not other_trials:
        return None
    return _bounds(newcombe(count, trials, others, other_trials), 100.0)


def _bounds(interval: tuple[float, float], factor: float) -> list[float] | None:
    low, high = interval
    return [factor * low, factor * high] if math.isfinite(low) and math.isfinite(high) else None


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
