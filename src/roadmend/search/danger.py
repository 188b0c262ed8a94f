"""How near an episode came to a collision: what the guided techniques climb."""

import math

import numpy as np
from numpy.typing import NDArray

from roadmend.core.geometry import outline_distances
from roadmend.core.jit import compiled
from roadmend.core.scene import Scene

FARTHEST = 50.0  # [m] objects beyond this are no danger
HORIZON = 5.0  # [s] times to collision beyond this count as this
CLOSING_WEIGHT = 1.0  # [m/s] metres that a second to collision is worth

Floats = NDArray[np.float64]


@compiled
def _least(
    gaps: Floats,
    ego_x: float,
    ego_y: float,
    ego_vx: float,
    ego_vy: float,
    x: Floats,
    y: Floats,
    yaw: Floats,
    speed: Floats,
) -> float:
    """Least danger [m] of N others, all arrays of shape (N,)."""
    least = np.inf
    for index in range(gaps.shape[0]):
        away_x, away_y = x[index] - ego_x, y[index] - ego_y
        relative_x = speed[index] * math.cos(yaw[index]) - ego_vx
        relative_y = speed[index] * math.sin(yaw[index]) - ego_vy
        closing = -(away_x * relative_x + away_y * relative_y) / max(math.hypot(away_x, away_y), 1e-6)
        seconds = HORIZON
        if closing > 1e-3:
            seconds = min(HORIZON, gaps[index] / closing)
        least = min(least, min(gaps[index], FARTHEST) + CLOSING_WEIGHT * seconds)
    return least


class Danger:
    """Least of distance + CLOSING_WEIGHT * time to collision over all ticks and participants.

    The distance [m] is that between the outlines; the time to collision [s] takes both to keep their velocity and is
    counted along the line between the centres. A queue is near but does not close in, so it ranks below a near miss.
    """

    def __init__(self) -> None:
        self.least = FARTHEST + CLOSING_WEIGHT * HORIZON  # [m]

    def watch(self, scene: Scene) -> None:
        """Count one tick."""
        ego, others = scene.ego, scene.objects
        if not len(others):
            return
        gaps = outline_distances(
            ego.x,
            ego.y,
            ego.yaw,
            ego.length,
            ego.width,
            others.x,
            others.y,
            others.yaw,
            others.length,
            others.width,
            FARTHEST,
        )
        danger = _least(
            gaps,
            ego.x,
            ego.y,
            ego.speed * math.cos(ego.yaw),
            ego.speed * math.sin(ego.yaw),
            others.x,
            others.y,
            others.yaw,
            others.speed,
        )
        self.least = min(self.least, danger)
