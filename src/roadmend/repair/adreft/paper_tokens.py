"""The paper's scene tokenizer (ADReFT section 3.1.1): every participant and every planned point is one token."""

import math

import numpy as np
from numpy.typing import NDArray

from roadmend.core.command import Decision
from roadmend.core.geometry import wrap_angle
from roadmend.core.jit import compiled, unnamed
from roadmend.core.route import Route
from roadmend.core.scene import EgoState, Objects, Scene
from roadmend.repair.adreft.tokenizer import TokenSet

Floats = NDArray[np.float64]

_PARTICIPANT, _POINT = 1.0, 2.0
_DISTANCE = 1.0 / 20.0  # per metre
_ANGLE = 1.0 / math.pi  # per radian
_SIZE = 1.0 / 5.0  # per metre


@compiled
def _write(
    row: NDArray[np.float32],
    category: float,
    ego: EgoState,
    x: float,
    y: float,
    yaw: float,
    length: float,
    width: float,
) -> None:
    cosine, sine = math.cos(ego.yaw), math.sin(ego.yaw)
    dx, dy = x - ego.x, y - ego.y
    row[0] = category
    row[1] = (dx * cosine + dy * sine) * _DISTANCE
    row[2] = (dy * cosine - dx * sine) * _DISTANCE
    row[3] = wrap_angle(yaw - ego.yaw) * _ANGLE
    row[4] = width * _SIZE
    row[5] = length * _SIZE


@compiled
def _fill(
    values: NDArray[np.float32], ego: EgoState, objects: Objects, plan_x: Floats, plan_y: Floats, plan_yaw: Floats
) -> None:
    """Write one token for each of N objects, then one for each of P planned points, shape (N + P, 6)."""
    ego = EgoState(*ego)
    for index in range(objects.shape[0]):
        other = objects[index]
        _write(values[index], _PARTICIPANT, ego, other.x, other.y, other.yaw, other.length, other.width)
    for index in range(plan_x.shape[0]):
        row = values[objects.shape[0] + index]
        _write(row, _POINT, ego, plan_x[index], plan_y[index], plan_yaw[index], ego.length, ego.width)


class PaperTokenizer:
    """Tokens {z, x, y, phi, w, h}: category, position, heading, width, length; participants first, then the plan.

    Category 1 is a participant, 2 a point of the planned trajectory, which has the ego's own width and length. Position
    and heading are relative to the ego: x ahead, y to the left, phi counter-clockwise in (-pi, pi]. Inputs of a network
    should be about 1, so positions are in units of 20 m, headings in units of pi and sizes in units of 5 m.
    """

    name = "paper"
    version = 1
    attributes = 6
    has_ego = False

    def reset(self, route: Route) -> None:
        """Nothing is remembered."""

    def tokens(self, scene: Scene, decision: Decision) -> TokenSet:
        """N = participants + planned points tokens."""
        ego, objects, plan = scene.ego, scene.objects, decision.trajectory
        count, points = len(objects), len(plan)
        values = np.empty((count + points, self.attributes), dtype=np.float32)
        rows = np.full(count + points, -1, dtype=np.int32)
        rows[:count] = np.arange(count, dtype=np.int32)
        _fill(values, unnamed(ego), objects.table, plan.x, plan.y, plan.yaw)
        return TokenSet(values, rows)
