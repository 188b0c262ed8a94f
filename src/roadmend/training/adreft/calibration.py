"""The threshold of the state monitor, and how good the monitor is at it."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roadmend.core.errors import InputError

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class MonitorQuality:
    """Of the frames above a threshold."""

    precision: float  # share of those above the threshold that are critical, 0 .. 1
    recall: float  # share of the critical ones that are above the threshold, 0 .. 1
    f1: float


def calibrate(scores: Floats, critical: NDArray[np.bool_], recall: float = 0.95) -> float:
    """lambda_safe: the largest threshold at which more than ``recall`` of the critical frames score above it.

    Args:
        scores: shape (F,), 0 .. 1.
        critical: whether a frame is critical, shape (F,).
        recall: 0 <= recall < 1 (ADReFT section 4: 0.95).

    Raises:
        InputError: no frame is critical.
    """
    found = np.sort(np.asarray(scores, dtype=np.float64)[critical])[::-1]
    if not len(found):
        mend = "give a corpus with violations in it, or set frames.validation_stride to less"
        raise InputError("validation split", "no frame is critical", mend)
    needed = min(len(found), math.floor(recall * len(found) + 1e-9) + 1)
    return float(np.nextafter(found[needed - 1], -np.inf))  # 'above' is strict


def monitor_quality(scores: Floats, critical: NDArray[np.bool_], threshold: float) -> MonitorQuality:
    """Precision, recall and F1 of saying 'critical' where a score is above a threshold; 0 where there is nothing."""
    said = scores > threshold
    hits = int(np.count_nonzero(said & critical))
    precision = hits / max(1, int(np.count_nonzero(said)))
    recall = hits / max(1, int(np.count_nonzero(critical)))
    f1 = 2.0 * precision * recall / (precision + recall) if hits else 0.0
    return MonitorQuality(precision, recall, f1)


def calibrate_untouched(highest: Floats, touched: float) -> float:
    """lambda_safe by what is left alone: the least threshold that few harmless drives ever score above.

    Args:
        highest: score of each drive, shape (D,), 0 .. 1.
        touched: at most this share of the drives may have a score above the threshold, 0 <= touched < 1.

    Raises:
        ValueError: there is no drive.
    """
    found = np.sort(np.asarray(highest, dtype=np.float64))[::-1]
    if not len(found):
        raise ValueError("there is no harmless drive")
    return float(found[math.floor(touched * len(found) + 1e-9)])  # 'above' is strict
