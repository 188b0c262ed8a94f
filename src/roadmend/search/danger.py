"""How near an episode came to a collision: what the guided techniques climb."""

import math

import numpy as np

from roadmend.core.geometry import outline_distances
from roadmend.core.scene import Scene

FARTHEST = 50.0  # [m] objects beyond this are no danger
HORIZON = 5.0  # [s] times to collision beyond this count as this
CLOSING_WEIGHT = 1.0  # [m/s] metres that a second to collision is worth


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
            ego.x, ego.y, ego.yaw, ego.length, ego.width,
            others.x, others.y, others.yaw, others.length, others.width, FARTHEST,
        )  # fmt: skip
        away_x, away_y = others.x - ego.x, others.y - ego.y
        relative_x = others.speed * np.cos(others.yaw) - ego.speed * math.cos(ego.yaw)
        relative_y = others.speed * np.sin(others.yaw) - ego.speed * math.sin(ego.yaw)
        apart = np.maximum(np.hypot(away_x, away_y), 1e-6)
        closing = -(away_x * relative_x + away_y * relative_y) / apart
        seconds = np.full(len(others), HORIZON)
        np.divide(gaps, closing, out=seconds, where=closing > 1e-3)
        danger = np.minimum(gaps, FARTHEST) + CLOSING_WEIGHT * np.minimum(seconds, HORIZON)
        self.least = min(self.least, float(danger.min()))
