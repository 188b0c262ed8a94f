"""The way one participant took, as a bag has it."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roadmend.recording.episode import BagEpisode

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """N moments at which a participant was seen, all arrays of shape (N,)."""

    id: int
    kind: int  # an ObjectKind
    length: float  # [m]
    width: float  # [m]
    stamp: NDArray[np.int64]  # [ns]
    x: Floats  # [m]
    y: Floats  # [m]
    yaw: Floats  # [rad]
    speed: Floats  # [m/s]
    acceleration: Floats  # [m/s2]

    def pose(self, stamp: int) -> tuple[float, float, float] | None:
        """Where it is at a stamp [ns]: as seen, or after the last sight straight on at constant speed.

        None before the first sight and between two sights that are not neighbours.
        """
        index = int(np.searchsorted(self.stamp, stamp, side="right")) - 1
        if index < 0:
            return None
        x, y, yaw = float(self.x[index]), float(self.y[index]), float(self.yaw[index])
        if self.stamp[index] == stamp:
            return x, y, yaw
        if index < len(self.stamp) - 1:
            return None
        way = float(self.speed[-1]) * (stamp - int(self.stamp[-1])) * 1e-9
        return x + way * math.cos(yaw), y + way * math.sin(yaw), yaw


def track_of(episode: BagEpisode, identity: int, begin: int, end: int) -> Track | None:
    """The way of a participant between two stamps [ns], both included; None where it was never seen."""
    stamps, rows = [], []
    kind, length, width = 0, 0.0, 0.0
    for stamp in episode.stamps:
        objects = episode.objects.get(stamp) if begin <= stamp <= end else None
        if objects is None:
            continue
        found = np.flatnonzero(objects.id == identity)
        if not len(found):
            continue
        at = int(found[0])
        kind, length, width = int(objects.kind[at]), float(objects.length[at]), float(objects.width[at])
        stamps.append(stamp)
        rows.append((objects.x[at], objects.y[at], objects.yaw[at], objects.speed[at], objects.acceleration[at]))
    if not rows:
        return None
    x, y, yaw, speed, acceleration = np.array(rows, dtype=np.float64).T.copy()
    seen = np.array(stamps, dtype=np.int64)
    return Track(identity, kind, length, width, seen, x, y, yaw, speed, acceleration)
