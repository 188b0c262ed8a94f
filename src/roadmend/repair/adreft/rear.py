"""Who closes in from behind: to brake in front of them is no precaution."""

import math

from roadmend.core.jit import compiled, unnamed
from roadmend.core.scene import EgoState, Objects, Scene
from roadmend.repair.conflict import way_coordinates

_CLOSE = 1.0  # [m] between bumpers: so near, somebody is at the rear already
_ASIDE = 0.4  # [m] beside the ego's outline that still counts as behind it
_TURNED = 0.6  # [rad] of headings that drive the same way


def time_to_rear(scene: Scene) -> float:
    """Time [s] until the first who drives the ego's way is at its rear, at today's speeds; inf: nobody closes in."""
    return float(_least_time(unnamed(scene.ego), scene.objects.table))


@compiled
def _least_time(ego: EgoState, objects: Objects) -> float:
    ego = EgoState(*ego)
    least = math.inf
    for index in range(objects.shape[0]):
        other = objects[index]
        along, aside, heading = way_coordinates(ego.x, ego.y, other.x, other.y, other.yaw, other.speed, other.yaw_rate)
        if along <= 0.0 or abs(aside) >= 0.5 * (ego.width + other.width) + _ASIDE:
            continue
        if math.cos(heading - ego.yaw) <= math.cos(_TURNED):
            continue
        gap = along - 0.5 * (ego.length + other.length) - _CLOSE
        closing = other.speed - ego.speed
        if gap <= 0.0:
            least = 0.0
        elif closing > 0.0:
            least = min(least, gap / closing)
    return least
