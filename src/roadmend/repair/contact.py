"""Rolls objects and ego forward in time and looks for contacts of their outlines."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from roadmend.core.geometry import Outline, corner_distance, fill_corners
from roadmend.core.jit import compiled
from roadmend.core.scene import EgoState, Objects
from roadmend.repair.planned_path import PlannedPath, coordinates_on, pose_at, position_at

Floats = NDArray[np.float64]


@compiled
def roll_object(poses: Floats, first: int, last: int, yaw_rate: float, acceleration: float, interval: float) -> None:
    """Continue one object's ``poses`` (rows x, y, yaw, speed) from step ``first`` to ``last``.

    Constant yaw rate [rad/s] and acceleration [m/s2]; the speed never changes its sign.
    """
    x, y, yaw, speed = poses[first, 0], poses[first, 1], poses[first, 2], poses[first, 3]
    cosine, sine = math.cos(yaw), math.sin(yaw)
    for step in range(first + 1, last + 1):
        after = max(0.0, speed + acceleration * interval) if speed > 0.0 else speed
        way = 0.5 * (speed + after) * interval
        if yaw_rate != 0.0:
            middle = yaw + 0.5 * yaw_rate * interval
            cosine, sine = math.cos(middle), math.sin(middle)
            yaw += yaw_rate * interval
        x += way * cosine
        y += way * sine
        speed = after
        poses[step, 0], poses[step, 1], poses[step, 2], poses[step, 3] = x, y, yaw, speed


class Forecast(NamedTuple):
    """N objects rolled forward."""

    objects: Objects  # as they are now
    poses: Floats  # shape (N, steps, 4): x, y [m], yaw [rad], speed [m/s]
    required: Floats  # [m] gap per object below which there is contact, negative where an object is left out
    interval: float  # [s] between two steps


@compiled
def braked_position(planned: float, speed: float, deceleration: float, time: float) -> float:
    """Arc length [m] after ``time`` [s]: the planned one, or less where braking from ``speed`` allows less.

    A negative ``deceleration`` [m/s2] stands for no braking at all; 0 for rolling on at ``speed``.
    """
    if deceleration < 0.0:
        return planned
    braking = time if deceleration == 0.0 else min(time, speed / deceleration)
    return min(planned, (speed - 0.5 * deceleration * braking) * braking)


@compiled
def is_follower(path: PlannedPath, ego: EgoState, other: Outline) -> bool:
    """Whether an object drives behind the ego on the ego's own lane: keeping clear of the ego is its task."""
    s, d, turned = coordinates_on(path, other.x, other.y, other.yaw)
    behind = s < -0.5 * (ego.length + other.length)
    return behind and abs(d) < 0.5 * (ego.width + other.width) and abs(turned) < 1.0


@compiled
def first_contact(
    path: PlannedPath, ego: EgoState, deceleration: float, forecast: Forecast, begin: int, end: int, focus: int
) -> tuple[int, int]:
    """Step and object of the first contact in steps ``begin`` .. ``end``, or -1 and -1.

    ``focus`` is the only object to look at, or -1 for all. An ego that rolls backwards counts as standing.
    """
    objects, poses, required = forecast.objects, forecast.poses, forecast.required
    speed = max(0.0, ego.speed)
    points, progress, interval, tail_speed = path.points, path.progress, path.interval, path.tail_speed
    own = np.empty((4, 2), dtype=np.float64)
    their = np.empty((4, 2), dtype=np.float64)
    own_radius = 0.5 * math.hypot(ego.length, ego.width)
    low, high = (0, poses.shape[0]) if focus < 0 else (focus, focus + 1)
    for step in range(begin, end + 1):
        time = step * forecast.interval
        position = braked_position(position_at(progress, interval, tail_speed, time), speed, deceleration, time)
        x, y, yaw = pose_at(points, path.size, position)
        fill_corners(own, x, y, yaw, ego.length, ego.width)
        for index in range(low, high):
            if required[index] < 0.0:
                continue
            length, width = objects[index].length, objects[index].width
            dx, dy = poses[index, step, 0] - x, poses[index, step, 1] - y
            reach = own_radius + 0.5 * math.hypot(length, width) + required[index]
            if dx * dx + dy * dy > reach * reach:
                continue
            fill_corners(their, poses[index, step, 0], poses[index, step, 1], poses[index, step, 2], length, width)
            if corner_distance(own, their) <= required[index]:
                return step, index
    return -1, -1


@compiled
def merit(path: PlannedPath, ego: EgoState, deceleration: float, forecast: Forecast, end: int) -> float:
    """How good a deceleration is where none keeps clear.

    The least gap [m] where outlines stay apart, otherwise minus the relative speed [m/s] at the first contact.
    """
    objects, poses, required = forecast.objects, forecast.poses, forecast.required
    speed = max(0.0, ego.speed)
    points, progress, interval, tail_speed = path.points, path.progress, path.interval, path.tail_speed
    own = np.empty((4, 2), dtype=np.float64)
    their = np.empty((4, 2), dtype=np.float64)
    own_radius = 0.5 * math.hypot(ego.length, ego.width)
    least, before = math.inf, 0.0
    for step in range(end + 1):
        time = step * forecast.interval
        position = braked_position(position_at(progress, interval, tail_speed, time), speed, deceleration, time)
        x, y, yaw = pose_at(points, path.size, position)
        own_speed = (position - before) / forecast.interval if step else speed
        before = position
        fill_corners(own, x, y, yaw, ego.length, ego.width)
        for index in range(poses.shape[0]):
            if required[index] < 0.0:
                continue
            length, width = objects[index].length, objects[index].width
            their_x, their_y, their_yaw = poses[index, step, 0], poses[index, step, 1], poses[index, step, 2]
            gap = math.hypot(their_x - x, their_y - y) - own_radius - 0.5 * math.hypot(length, width)
            if gap >= least:
                continue
            fill_corners(their, their_x, their_y, their_yaw, length, width)
            least = min(least, corner_distance(own, their))
            if least <= 0.0:
                their_speed = poses[index, step, 3]
                return -math.hypot(
                    own_speed * math.cos(yaw) - their_speed * math.cos(their_yaw),
                    own_speed * math.sin(yaw) - their_speed * math.sin(their_yaw),
                )
    return least
