"""How near an episode came to a collision: what the guided techniques climb."""

import math

import numpy as np

from roadmend.core.geometry import outline_distances
from roadmend.core.jit import compiled
from roadmend.core.scene import EgoState, Objects, Scene

FARTHEST = 50.0  # [m] objects beyond this are no danger
HORIZON = 5.0  # [s] times to collision beyond this count as this
CLOSING_WEIGHT = 1.0  # [m/s] metres that a second to collision is worth


@compiled
def _least(ego: EgoState, ego_vx: float, ego_vy: float, others: Objects) -> float:
    """Least danger [m] of N others; the ego's velocity [m/s] comes in the map frame."""
    gaps = outline_distances(ego, others, FARTHEST)
    least = np.inf
    for index in range(others.shape[0]):
        other = others[index]
        away_x, away_y = other.x - ego.x, other.y - ego.y
        relative_x = other.speed * math.cos(other.yaw) - ego_vx
        relative_y = other.speed * math.sin(other.yaw) - ego_vy
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
        if len(scene.objects):
            ego = scene.ego
            velocity = ego.speed * math.cos(ego.yaw), ego.speed * math.sin(ego.yaw)
            self.least = min(self.least, _least(ego, *velocity, scene.objects.table))
