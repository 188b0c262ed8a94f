"""The scene as a vector of fixed size, for models that need one: the ego, its plan, the K nearest participants."""

import math

import numpy as np
from numpy.typing import NDArray

from roadmend.core.command import Decision
from roadmend.core.jit import compiled, unnamed
from roadmend.core.scene import EgoState, Objects, Scene

Floats = NDArray[np.float64]

VERSION = 1  # to be raised whenever the same scene gives other values
K = 8  # participants; those farther away than the K-th are left out, missing ones are zeros
PLAN_TIMES = (1.0, 2.0, 3.0)  # [s]
PER_OBJECT = 9  # presence, x, y, cos and sin of the heading, relative velocity x and y, length, width
_EGO = 3  # speed, yaw rate, whether there is a plan
SIZE = _EGO + 2 * len(PLAN_TIMES) + K * PER_OBJECT

_TIMES = np.array(PLAN_TIMES)
_DISTANCE, _SPEED, _LENGTH, _WIDTH = 1.0 / 40.0, 1.0 / 15.0, 1.0 / 10.0, 1.0 / 3.0


@compiled
def _fill(
    vector: NDArray[np.float32],
    ego: EgoState,
    interval: float,
    plan_x: Floats,
    plan_y: Floats,
    times: Floats,
    nearest: int,
    objects: Objects,
) -> None:
    ego = EgoState(*ego)
    vector[:] = 0.0
    cosine, sine = math.cos(ego.yaw), math.sin(ego.yaw)
    vector[0], vector[1] = ego.speed * _SPEED, ego.yaw_rate
    at = 3
    if plan_x.shape[0] > 0:
        vector[2] = 1.0
        for index in range(times.shape[0]):
            point = min(plan_x.shape[0] - 1, max(0, int(times[index] / interval + 0.5) - 1))
            dx, dy = plan_x[point] - ego.x, plan_y[point] - ego.y
            vector[at + 2 * index] = (dx * cosine + dy * sine) * _DISTANCE
            vector[at + 2 * index + 1] = (dy * cosine - dx * sine) * _DISTANCE
    at += 2 * times.shape[0]
    count = objects.shape[0]
    squares = np.empty(count, dtype=np.float64)
    for index in range(count):
        squares[index] = (objects[index].x - ego.x) ** 2 + (objects[index].y - ego.y) ** 2
    for _ in range(min(nearest, count)):
        best = 0
        for index in range(1, count):
            if squares[index] < squares[best]:
                best = index
        squares[best] = math.inf
        other = objects[best]
        dx, dy, turned = other.x - ego.x, other.y - ego.y, other.yaw - ego.yaw
        vector[at] = 1.0
        vector[at + 1] = (dx * cosine + dy * sine) * _DISTANCE
        vector[at + 2] = (dy * cosine - dx * sine) * _DISTANCE
        vector[at + 3], vector[at + 4] = math.cos(turned), math.sin(turned)
        vector[at + 5] = (other.speed * math.cos(turned) - ego.speed) * _SPEED
        vector[at + 6] = other.speed * math.sin(turned) * _SPEED
        vector[at + 7], vector[at + 8] = other.length * _LENGTH, other.width * _WIDTH
        at += 9


def state_vector(scene: Scene, decision: Decision) -> NDArray[np.float32]:
    """The scene and the plan in the ego frame (x ahead, y to the left), shape (SIZE,), scaled to about 1.

    Entries: speed, yaw rate and whether there is a plan; planned x and y at PLAN_TIMES; then, from the nearest on, K
    times presence, x, y, cosine and sine of the relative heading, velocity x and y minus the ego's, length and width.
    """
    ego, plan, objects = scene.ego, decision.trajectory, scene.objects
    vector = np.empty(SIZE, dtype=np.float32)
    _fill(vector, unnamed(ego), plan.interval, plan.x, plan.y, _TIMES, K, objects.table)
    return vector
