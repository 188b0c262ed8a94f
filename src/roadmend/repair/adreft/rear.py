"""Who closes in from behind: to brake in front of them is no precaution."""

import math

import numpy as np
from numpy.typing import NDArray

from roadmend.core.jit import compiled
from roadmend.core.scene import Scene
from roadmend.repair.conflict import way_coordinates

Floats = NDArray[np.float64]

_CLOSE = 1.0  # [m] between bumpers: so near, somebody is at the rear already
_ASIDE = 0.4  # [m] beside the ego's outline that still counts as behind it
_TURNED = 0.6  # [rad] of headings that drive the same way


def time_to_rear(scene: Scene) -> float:
    """Time [s] until the first who drives the ego's way is at its rear, at today's speeds; inf: nobody closes in."""
    ego, objects = scene.ego, scene.objects
    return float(
        _least_time(
            ego.x,
            ego.y,
            ego.yaw,
            ego.speed,
            ego.length,
            ego.width,
            objects.x,
            objects.y,
            objects.yaw,
            objects.speed,
            objects.yaw_rate,
            objects.length,
            objects.width,
        )
    )


@compiled
def _least_time(
    ego_x: float,
    ego_y: float,
    ego_yaw: float,
    ego_speed: float,
    ego_length: float,
    ego_width: float,
    x: Floats,
    y: Floats,
    yaw: Floats,
    speed: Floats,
    yaw_rate: Floats,
    length: Floats,
    width: Floats,
) -> float:
    least = math.inf
    for index in range(x.shape[0]):
        along, aside, heading = way_coordinates(
            ego_x, ego_y, x[index], y[index], yaw[index], speed[index], yaw_rate[index]
        )
        if along <= 0.0 or abs(aside) >= 0.5 * (ego_width + width[index]) + _ASIDE:
            continue
        if math.cos(heading - ego_yaw) <= math.cos(_TURNED):
            continue
        gap = along - 0.5 * (ego_length + length[index]) - _CLOSE
        closing = speed[index] - ego_speed
        if gap <= 0.0:
            least = 0.0
        elif closing > 0.0:
            least = min(least, gap / closing)
    return least
