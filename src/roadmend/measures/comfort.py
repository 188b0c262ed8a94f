"""Comfortness: the share of a drive within bounds that passengers find comfortable.

The bounds are nuPlan's (Karnchanachari et al. 2024, metric "ego is comfortable", from human drives), which Bench2Drive
takes over (Jia et al. 2024, "driving smoothness"): a drive is cut into pieces of 2 s, and a piece is comfortable if all
six quantities stay within their bounds, after smoothing by a second-order polynomial over 7 samples at 10 Hz (Savitzky
and Golay 1964). Where we differ: accelerations come from speed and yaw rate, the only motion that odometry carries; and
the yaw acceleration is the derivative of the yaw rate, as nuPlan defines it (Bench2Drive's tool bounds the rate itself).
"""

from collections.abc import Sequence
from functools import cache

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

LONGITUDINAL = (-4.05, 2.40)  # [m/s2]
LATERAL = 4.89  # [m/s2] either way
JERK = 8.37  # [m/s3] of the acceleration's magnitude, either way
LONGITUDINAL_JERK = 4.13  # [m/s3] either way
YAW_RATE = 0.95  # [rad/s] either way
YAW_ACCELERATION = 1.93  # [rad/s2] either way

_INTERVAL = 0.1  # [s] between samples
_PIECE = 20  # samples
_WINDOW = 7  # samples
_ORDER = 2


def comfort(times: Sequence[float], speeds: Sequence[float], yaw_rates: Sequence[float]) -> float | None:
    """The share of pieces that are comfortable, 0 .. 1; a drive shorter than a piece counts as one.

    Args:
        times: of the samples [s], rising, shape (N,); gaps are bridged by straight lines.
        speeds: [m/s], shape (N,).
        yaw_rates: [rad/s], shape (N,).

    Returns:
        None where the drive is too short to be smoothed.
    """
    if len(times) < 2:
        return None
    # Half a tick of slack, so that rounded times neither gain nor lose the last sample.
    grid = np.arange(times[0], times[-1] + 1e-6, _INTERVAL)
    speed, yaw_rate = np.interp(grid, times, speeds), np.interp(grid, times, yaw_rates)
    along = np.diff(speed) / _INTERVAL
    speed, yaw_rate = speed[1:], yaw_rate[1:]
    across = speed * yaw_rate
    size = min(_PIECE, len(along))
    if size < _WINDOW:
        return None
    begins = range(0, len(along) - size + 1, size)
    good = [_is_comfortable(along[b : b + size], across[b : b + size], yaw_rate[b : b + size]) for b in begins]
    return sum(good) / len(good)


def _is_comfortable(along: Floats, across: Floats, yaw_rate: Floats) -> bool:
    smooth, slope = smoothers(len(along))
    magnitude = np.hypot(along, across)
    smoothed = smooth @ along
    return bool(
        smoothed.min() > LONGITUDINAL[0]
        and smoothed.max() < LONGITUDINAL[1]
        and np.abs(smooth @ across).max() < LATERAL
        and np.abs(slope @ (smooth @ magnitude)).max() < JERK
        and np.abs(slope @ smoothed).max() < LONGITUDINAL_JERK
        and np.abs(smooth @ yaw_rate).max() < YAW_RATE
        and np.abs(slope @ (smooth @ yaw_rate)).max() < YAW_ACCELERATION
    )


@cache
def smoothers(size: int) -> tuple[Floats, Floats]:
    """Matrices (size x size) that smooth a signal and that give the slope [1/s] of the smoothed signal.

    Each sample is fitted by the polynomial over the window around it, those at the ends by the first or last window.
    """
    half = _WINDOW // 2
    smooth, slope = np.zeros((size, size)), np.zeros((size, size))
    for row in range(size):
        first = min(max(row - half, 0), size - _WINDOW)
        offsets = (np.arange(first, first + _WINDOW) - row) * _INTERVAL
        fit = np.linalg.pinv(np.vander(offsets, _ORDER + 1, increasing=True))
        smooth[row, first : first + _WINDOW], slope[row, first : first + _WINDOW] = fit[0], fit[1]
    return smooth, slope
