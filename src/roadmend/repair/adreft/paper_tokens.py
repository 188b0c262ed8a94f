"""The paper's scene tokenizer (ADReFT section 3.1.1): every participant and every planned point is one token."""

import math

import numpy as np
from numpy.typing import NDArray

from roadmend.core.command import Decision
from roadmend.core.geometry import wrap_angle
from roadmend.core.jit import compiled
from roadmend.core.route import Route
from roadmend.core.scene import Scene
from roadmend.repair.adreft.tokenizer import TokenSet

Floats = NDArray[np.float64]

_PARTICIPANT, _POINT = 1.0, 2.0
_DISTANCE = 1.0 / 20.0  # per metre
_ANGLE = 1.0 / math.pi  # per radian
_SIZE = 1.0 / 5.0  # per metre


@compiled
def fill_tokens(
    values: NDArray[np.float32],
    category: float,
    x: float,
    y: float,
    yaw: float,
    other_x: Floats,
    other_y: Floats,
    other_yaw: Floats,
    width: Floats,
    length: Floats,
) -> None:
    """Write N tokens of one category, shape (N, 6), for outlines given in the map frame, seen from the pose x, y, yaw."""
    cosine, sine = math.cos(yaw), math.sin(yaw)
    for index in range(other_x.shape[0]):
        dx, dy = other_x[index] - x, other_y[index] - y
        values[index, 0] = category
        values[index, 1] = (dx * cosine + dy * sine) * _DISTANCE
        values[index, 2] = (dy * cosine - dx * sine) * _DISTANCE
        values[index, 3] = wrap_angle(other_yaw[index] - yaw) * _ANGLE
        values[index, 4] = width[index] * _SIZE
        values[index, 5] = length[index] * _SIZE


class PaperTokenizer:
    """Tokens {z, x, y, phi, w, h}: category, position, heading, width, length; participants first, then the plan.

    Category 1 is a participant, 2 a point of the planned trajectory, which has the ego's own width and length. Position
    and heading are relative to the ego: x ahead, y to the left, phi counter-clockwise in (-pi, pi]. Inputs of a network
    should be about 1, so positions are in units of 20 m, headings in units of pi and sizes in units of 5 m.
    """

    name = "paper"
    version = 1
    attributes = 6

    def reset(self, route: Route) -> None:
        """Nothing is remembered."""

    def tokens(self, scene: Scene, decision: Decision) -> TokenSet:
        """N = participants + planned points tokens."""
        ego, objects, plan = scene.ego, scene.objects, decision.trajectory
        count, points = len(objects), len(plan)
        values = np.empty((count + points, self.attributes), dtype=np.float32)
        rows = np.full(count + points, -1, dtype=np.int32)
        rows[:count] = np.arange(count, dtype=np.int32)
        fill_tokens(
            values[:count],
            _PARTICIPANT,
            ego.x,
            ego.y,
            ego.yaw,
            objects.x,
            objects.y,
            objects.yaw,
            objects.width,
            objects.length,
        )
        fill_tokens(
            values[count:],
            _POINT,
            ego.x,
            ego.y,
            ego.yaw,
            plan.x,
            plan.y,
            plan.yaw,
            np.full(points, ego.width),
            np.full(points, ego.length),
        )
        return TokenSet(values, rows)
