"""Where the predicted way of an object and the planned path of the ego share ground, and when."""

import math
from typing import NamedTuple

from roadmend.core.geometry import Outline, wrap_angle
from roadmend.core.jit import compiled
from roadmend.repair.planned_path import PlannedPath

_STRAIGHT = 0.05  # [rad/s] below this yaw rate an object goes straight on


@compiled
def way_coordinates(
    px: float, py: float, x: float, y: float, yaw: float, speed: float, yaw_rate: float
) -> tuple[float, float, float]:
    """A point seen from an object's way: distance along it [m], offset from it [m], heading of the way there [rad].

    The way is a straight line, or a circle where the object turns; points behind are at negative distances.
    """
    dx, dy = px - x, py - y
    cosine, sine = math.cos(yaw), math.sin(yaw)
    if abs(yaw_rate) < _STRAIGHT or speed < 1.0:
        return dx * cosine + dy * sine, dy * cosine - dx * sine, yaw
    radius = speed / yaw_rate  # signed, positive to the left
    from_x, from_y = dx + radius * sine, dy - radius * cosine  # from the centre of the circle
    distance = math.hypot(from_x, from_y)
    swept = math.atan2(from_y, from_x) - math.atan2(-radius * cosine, radius * sine)
    swept = wrap_angle(swept) if yaw_rate > 0.0 else -wrap_angle(swept)
    offset = radius - distance if radius > 0.0 else distance + radius
    return abs(radius) * swept, offset, yaw + (swept if yaw_rate > 0.0 else -swept)


class SharedGround(NamedTuple):
    """A stretch of the ego's path that lies in the swath of an object's way."""

    begin: float  # [m] along the path; inf where the two share nothing
    end: float  # [m] along the path
    least: float  # [m] along the object's way
    greatest: float  # [m] along the object's way
    turned: float  # [rad] heading of that way relative to the path where the stretch begins


@compiled
def shared_ground(path: PlannedPath, other: Outline, half_swath: float, behind: float, ahead: float) -> SharedGround:
    """The first stretch of the path ahead that lies in the swath of an object's way.

    ``half_swath`` is half the sum of both widths [m]; points from ``behind`` [m] behind the object's centre to
    ``ahead`` [m] along its way count.
    """
    points = path.points
    begin, end, least, greatest, turned = math.inf, math.inf, math.inf, -math.inf, 0.0
    for index in range(path.zero, path.size):
        px, py = points[0, index], points[1, index]
        along, aside, heading = way_coordinates(px, py, other.x, other.y, other.yaw, other.speed, other.yaw_rate)
        if abs(aside) < half_swath and -behind <= along <= ahead:
            if begin == math.inf:
                begin = points[2, index]
                turned = wrap_angle(heading - points[3, index])
            end = points[2, index]
            least, greatest = min(least, along), max(greatest, along)
        elif begin < math.inf:
            break
    return SharedGround(begin, end, least, greatest, turned)
