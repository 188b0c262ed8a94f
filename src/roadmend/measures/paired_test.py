"""Student's t: whether paired differences are 0 in the mean, and the interval of a mean of few values."""

import math
from collections.abc import Sequence
from statistics import fmean, stdev

import scipy  # scipy.stats takes seconds to import, and is only when it is first used

from roadmend.measures.intervals import Interval


def paired_p_value(first: Sequence[float], second: Sequence[float]) -> float | None:
    """The two-sided p value of the paired t-test; None where it is not defined: fewer than two pairs, or all equal.

    Raises:
        ValueError: there are not as many of the one as of the other.
    """
    differences = [a - b for a, b in zip(first, second, strict=True)]
    if len(differences) < 2 or stdev(differences) == 0.0:
        return None
    return float(scipy.stats.ttest_rel(first, second).pvalue)


def mean_interval(values: Sequence[float]) -> Interval | None:
    """The 95 % interval of a mean by Student's t; None for fewer than two values."""
    if len(values) < 2:
        return None
    half = float(scipy.stats.t.ppf(0.975, len(values) - 1)) * stdev(values) / math.sqrt(len(values))
    return fmean(values) - half, fmean(values) + half
