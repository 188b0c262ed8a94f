"""Whether a monitor's score is the probability that it stands for."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

BINS = 10


@dataclass(frozen=True, slots=True)
class ReliabilityBin:
    """Of the moments whose score lies in one tenth."""

    weight: float  # share of all moments' weight, 0 .. 1
    score: float  # mean
    seen: float  # mean share of futures that violate


@dataclass(frozen=True, slots=True)
class Reliability:
    """How far scores are from what was seen, over moments by their weight."""

    moments: int
    rate: float  # mean share of futures that violate
    score: float  # mean
    brier: float  # mean squared difference (Brier 1950)
    brier_of_rate: float  # of whoever says the rate everywhere
    calibration_error: float  # expected: mean over the bins of |score - seen| (Naeini et al. 2015)
    bins: tuple[ReliabilityBin, ...]  # those that hold a moment, the lowest scores first


def reliability(scores: Floats, seen: Floats, weight: Floats) -> Reliability:
    """Judge scores.

    Args:
        scores: 0 .. 1, shape (F,), F > 0.
        seen: share of futures that violate, shape (F,).
        weight: above 0, shape (F,).
    """
    weight = weight / weight.sum()
    rate = float(weight @ seen)
    places = np.minimum((scores * BINS).astype(np.int64), BINS - 1)
    bins = []
    for place in np.unique(places):
        inside = places == place
        share = float(weight[inside].sum())
        means = [float(weight[inside] @ values[inside]) / share for values in (scores, seen)]
        bins.append(ReliabilityBin(share, means[0], means[1]))
    return Reliability(
        len(scores),
        rate,
        float(weight @ scores),
        float(weight @ (scores - seen) ** 2),
        float(weight @ (rate - seen) ** 2),
        sum(each.weight * abs(each.score - each.seen) for each in bins),
        tuple(bins),
    )
