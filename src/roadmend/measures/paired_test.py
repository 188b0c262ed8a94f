"""Student's t: whether paired differences are 0 in the mean, and the interval of a mean of few values."""

import math
from collections.abc import Sequence
from statistics import fmean, stdev

from roadmend.measures.intervals import Interval


def paired_p_value(first: Sequence[float], second: Sequence[float]) -> float | None:
    """The two-sided p value of the paired t-test; None where it is not defined: fewer than two pairs, or all equal.

    Raises:
        ValueError: there are not as many of the one as of the other.
    """
    differences = [a - b for a, b in zip(first, second, strict=True)]
    if len(differences) < 2 or (spread := stdev(differences)) == 0.0:
        return None
    t = fmean(differences) / (spread / math.sqrt(len(differences)))
    return 1.0 - share_within(abs(t), len(differences) - 1)


def mean_interval(values: Sequence[float]) -> Interval | None:
    """The 95 % interval of a mean by Student's t; None for fewer than two values."""
    if len(values) < 2:
        return None
    low, high = 0.0, 1000.0
    while high - low > 1e-9:  # the share grows with t
        middle = 0.5 * (low + high)
        low, high = (middle, high) if share_within(middle, len(values) - 1) < 0.95 else (low, middle)
    half = high * stdev(values) / math.sqrt(len(values))
    return fmean(values) - half, fmean(values) + half


def share_within(t: float, freedom: int) -> float:
    """The probability that Student's t with so many degrees of freedom lies within -t .. t, for t >= 0.

    Source: Abramowitz and Stegun 26.7.3 and 26.7.4.
    """
    angle = math.atan(t / math.sqrt(freedom))
    cosine = math.cos(angle)
    odd = freedom % 2
    term = cosine if odd else 1.0
    total = term if freedom > 1 else 0.0
    for number in range(2 + odd, freedom - 1, 2):
        term *= cosine * cosine * (number - 1) / number
        total += term
    if odd:
        return 2.0 / math.pi * (angle + math.sin(angle) * total)
    return math.sin(angle) * total
