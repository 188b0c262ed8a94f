"""What the ego did in an episode, as a vector of fixed length that behaviours are compared by."""

import numpy as np
from numpy.typing import NDArray

from roadmend.core.scene import EgoState

Floats = NDArray[np.float64]

SAMPLES = 8  # points that each sequence is resampled to, whatever the episode's duration
_SCALES = (15.0, 4.0, 0.5)  # [m/s], [m/s2], [rad/s] that count as 1
_SUMMARIES = (np.mean, np.std, np.min, np.max)
FEATURES = len(_SCALES) * (SAMPLES + len(_SUMMARIES))


class BehaviourRecorder:
    """Collects the ego's motion tick by tick."""

    def __init__(self, interval: float) -> None:
        """Start a record.

        Args:
            interval: time between ticks [s].
        """
        self._interval = interval
        self._speeds: list[float] = []
        self._yaw_rates: list[float] = []

    def watch(self, ego: EgoState) -> None:
        """Count one tick."""
        self._speeds.append(ego.speed)
        self._yaw_rates.append(ego.yaw_rate)

    def features(self) -> tuple[float, ...]:
        """Speed, acceleration and heading rate: SAMPLES points of each, then mean, deviation, least and most of each.

        Scaled to about 1 and rounded, so that they are the same after a way through a file. Shape (FEATURES,); zeros
        for an episode without ticks.
        """
        if not self._speeds:
            return (0.0,) * FEATURES
        speed = np.array(self._speeds)
        acceleration = np.diff(speed, prepend=speed[0]) / self._interval
        sequences = [
            sequence / scale
            for sequence, scale in zip((speed, acceleration, np.array(self._yaw_rates)), _SCALES, strict=True)
        ]
        values = [*(_resampled(sequence) for sequence in sequences), *(_summary(sequence) for sequence in sequences)]
        return tuple(round(float(value), 4) for value in np.concatenate(values))


def _resampled(sequence: Floats) -> Floats:
    return np.interp(np.linspace(0.0, len(sequence) - 1.0, SAMPLES), np.arange(len(sequence)), sequence)


def _summary(sequence: Floats) -> Floats:
    return np.array([float(summary(sequence)) for summary in _SUMMARIES])
