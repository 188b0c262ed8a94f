"""95 % intervals: of a share, of the difference of two shares, and of anything else by the bootstrap."""

import math
from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np
import scipy  # scipy.stats takes seconds to import, and is only when it is first used
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Interval = tuple[float, float]

RESAMPLES = 2000
_DIGITS = 9  # of what the bootstrap gives; matrix products differ in the last bits between CPUs
SEED = 20260715  # of every bootstrap: the same results give the same intervals


def wilson(successes: int, trials: int) -> Interval:
    """The Wilson score interval of a share (Wilson 1927).

    Raises:
        ValueError: there were no trials.
    """
    if trials < 1:
        raise ValueError("no trials")
    low, high = scipy.stats.binomtest(successes, trials).proportion_ci(0.95, method="wilson")
    return float(low), float(high)


def newcombe(successes: int, trials: int, others: int, other_trials: int) -> Interval:
    """The interval of a difference of two independent shares: Newcombe's hybrid score (1998, method 10).

    A bootstrap would do for most shares, but where everything was fixed and nothing degraded it would claim to be
    certain, since it can only draw what it has seen.

    Raises:
        ValueError: there were no trials of one kind.
    """
    first, second = successes / max(trials, 1), others / max(other_trials, 1)
    (low, high), (other_low, other_high) = wilson(successes, trials), wilson(others, other_trials)
    difference = first - second
    below = math.hypot(first - low, other_high - second)
    above = math.hypot(high - first, second - other_low)
    return max(-1.0, difference - below), min(1.0, difference + above)


def bootstrap(
    strata: tuple[Floats, ...], statistic: Callable[[tuple[Floats, ...]], Floats], resamples: int = RESAMPLES
) -> Interval:
    """The percentile bootstrap interval of a statistic of sums.

    Args:
        strata: tables of shape (n_i, k), a row a case; cases are drawn with replacement within each.
        statistic: from the columns' sums of each stratum, shape (resamples, k) each, to a value each (resamples,);
            NaN where it is not defined.
        resamples: how many samples are drawn.

    Returns:
        The 2.5 % and the 97.5 % point, rounded so that they are the same on every CPU; NaN where the statistic is
        never defined.
    """
    draws = _draws(tuple(len(table) for table in strata), resamples)
    values = statistic(tuple(counts @ table for counts, table in zip(draws, strata, strict=True)))
    values = values[np.isfinite(values)]
    if not len(values):
        return math.nan, math.nan
    low, high = np.percentile(values, (2.5, 97.5))
    return round(float(low), _DIGITS), round(float(high), _DIGITS)


def by_group(table: Floats, groups: Sequence[str]) -> Floats:
    """Rows of one group added up, so that ``bootstrap`` draws groups: of what is alike one tells little more than another.

    Args:
        table: shape (n, k); a column of ones counts the rows, by which a statistic has to divide.
        groups: of each row.

    Returns:
        Shape (number of groups, k).
    """
    names = {name: place for place, name in enumerate(dict.fromkeys(groups))}
    sums = np.zeros((len(names), table.shape[1]))
    np.add.at(sums, [names[name] for name in groups], table)
    return sums


@lru_cache(maxsize=8)
def _draws(sizes: tuple[int, ...], resamples: int) -> tuple[Floats, ...]:
    """How often each case is drawn, shape (resamples, n_i) a stratum; the same for all that have as many cases."""
    generator = np.random.default_rng(SEED)
    return tuple(
        generator.multinomial(size, np.full(size, 1.0 / max(size, 1)), size=resamples).astype(np.float64)
        if size
        else np.zeros((resamples, 0))
        for size in sizes
    )
