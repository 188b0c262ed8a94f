"""Whether vehicles move as bodies on tyres can: accelerations from their positions, held against physical bounds."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from roadmend.core.tick import INTERVAL
from roadmend.safe.film import Film
from roadmend.world.ego import GRAVITY

Floats = NDArray[np.float64]

LONGITUDINAL_BOUND = GRAVITY  # [m/s2] braking or speeding up
LATERAL_BOUND = 0.5 * GRAVITY  # [m/s2]
_WINDOW = 11  # ticks (0.5 s) that an acceleration is fitted over: what a body's yaw and pitch need to follow
_LEAST = 5  # ticks of a vehicle that is there for less than a window
_STANDING = 0.5  # [m/s] below which there is no direction of travel
_ROUNDING = 1.02  # what positions in centimetres and a fit leave of a bound that is kept


_NONE: Mapping[str, int] = MappingProxyType({})


@dataclass(frozen=True, slots=True)
class Motion:
    """The hardest accelerations of one vehicle [m/s2], sizes."""

    longitudinal: float
    lateral: float

    @property
    def is_physical(self) -> bool:
        """Whether both are within the bounds."""
        return self.longitudinal <= LONGITUDINAL_BOUND * _ROUNDING and self.lateral <= LATERAL_BOUND * _ROUNDING


def motions_of(film: Film, impacts: Mapping[str, int] = _NONE) -> Mapping[str, Motion]:
    """The hardest accelerations of every vehicle, the ego too, up to the last tick.

    Args:
        film: where everybody was.
        impacts: by name, the tick at which a vehicle struck something that stands fixed. What that does to it in a tenth
            of a second is the crash and no driving: the track is measured up to it and from there on, not across it.
    """
    return {name: _apart(film.track(name), impacts.get(name)) for name in film.names if name not in film.fixed}


def _apart(track: Floats, tick: int | None) -> Motion:
    if tick is None:
        return motion_of(track)
    place = int(np.searchsorted(track[:, 0], tick, side="right"))
    parts = motion_of(track[:place]), motion_of(track[place:])
    return Motion(max(part.longitudinal for part in parts), max(part.lateral for part in parts))


def motion_of(track: Floats) -> Motion:
    """The hardest accelerations on a track of ticks and places (N x 2 or more columns after the tick).

    A parabola is fitted to the places of every half second (Savitzky and Golay 1964): its curvature in time is the
    acceleration, its slope the direction of travel. A jump from place to place shows as what it would take to drive it.
    """
    times, places = track[:, 0], track[:, 1:3]
    if len(times) < _LEAST:
        return Motion(0.0, 0.0)
    if np.any(np.diff(times) != 1):  # it was away in between: each stay by itself
        cut = int(np.flatnonzero(np.diff(times) != 1)[0]) + 1
        parts = motion_of(track[:cut]), motion_of(track[cut:])
        return Motion(max(part.longitudinal for part in parts), max(part.lateral for part in parts))
    window = min(_WINDOW, len(times) - (len(times) + 1) % 2)
    half = window // 2
    steps = np.arange(-half, half + 1) * INTERVAL
    slope, curvature = np.linalg.pinv(np.vander(steps, 3, increasing=True))[1:]
    windows = np.lib.stride_tricks.sliding_window_view(places, window, axis=0)  # N x 2 x window
    velocity, acceleration = windows @ slope, 2.0 * (windows @ curvature)
    speed = np.hypot(velocity[:, 0], velocity[:, 1])
    moves = speed > _STANDING
    along = velocity[moves] / speed[moves, None]
    forward = np.abs((acceleration[moves] * along).sum(axis=1))
    sideways = np.abs(acceleration[moves, 1] * along[:, 0] - acceleration[moves, 0] * along[:, 1])
    # What hardly moves has no direction: all that it does counts along it.
    still = np.hypot(*acceleration[~moves].T)
    return Motion(float(np.concatenate([forward, still]).max(initial=0.0)), float(sideways.max(initial=0.0)))
