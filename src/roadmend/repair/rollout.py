"""Rolls objects and ego forward in time and looks for contacts of their outlines."""

import math

import numpy as np
from numpy.typing import NDArray

from roadmend.core.geometry import corner_distance, fill_corners
from roadmend.core.jit import compiled
from roadmend.repair.path import coordinates_on, planned_position, pose_on

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


@compiled
def ego_position(
    progress: Floats, plan_interval: float, tail_speed: float, speed: float, deceleration: float, time: float
) -> float:
    """Arc length [m] after ``time`` [s]: the plan's, or less where braking from ``speed`` allows less.

    A negative ``deceleration`` [m/s2] stands for no braking at all; 0 for rolling on at ``speed``.
    """
    planned = planned_position(progress, plan_interval, tail_speed, time)
    if deceleration < 0.0:
        return planned
    braking = time if deceleration == 0.0 else min(time, speed / deceleration)
    return min(planned, (speed - 0.5 * deceleration * braking) * braking)


@compiled
def is_follower(
    points: Floats,
    count: int,
    ego_length: float,
    ego_width: float,
    x: float,
    y: float,
    yaw: float,
    length: float,
    width: float,
) -> bool:
    """Whether an object drives behind the ego on the ego's own lane: keeping clear of the ego is its task."""
    s, d, turned = coordinates_on(points, count, x, y, yaw)
    return s < -0.5 * (ego_length + length) and abs(d) < 0.5 * (ego_width + width) and abs(turned) < 1.0


@compiled
def first_contact(
    points: Floats,
    count: int,
    progress: Floats,
    plan_interval: float,
    tail_speed: float,
    speed: float,
    ego_length: float,
    ego_width: float,
    deceleration: float,
    poses: Floats,
    length: Floats,
    width: Floats,
    required: Floats,
    begin: int,
    end: int,
    focus: int,
    interval: float,
) -> tuple[int, int]:
    """Step and object of the first contact in steps ``begin`` .. ``end``, or -1 and -1.

    ``poses`` are the objects rolled forward, shape (N, steps, 4); ``required`` is the gap per object [m] below which
    there is contact, negative where an object is left out; ``focus`` is the only object to look at, or -1 for all.
    """
    own = np.empty((4, 2), dtype=np.float64)
    their = np.empty((4, 2), dtype=np.float64)
    own_radius = 0.5 * math.hypot(ego_length, ego_width)
    low, high = (0, poses.shape[0]) if focus < 0 else (focus, focus + 1)
    for step in range(begin, end + 1):
        position = ego_position(progress, plan_interval, tail_speed, speed, deceleration, step * interval)
        x, y, yaw = pose_on(points, count, position)
        fill_corners(own, x, y, yaw, ego_length, ego_width)
        for index in range(low, high):
            if required[index] < 0.0:
                continue
            dx, dy = poses[index, step, 0] - x, poses[index, step, 1] - y
            reach = own_radius + 0.5 * math.hypot(length[index], width[index]) + required[index]
            if dx * dx + dy * dy > reach * reach:
                continue
            fill_corners(
                their, poses[index, step, 0], poses[index, step, 1], poses[index, step, 2], length[index], width[index]
            )
            if corner_distance(own, their) <= required[index]:
                return step, index
    return -1, -1


@compiled
def merit(
    points: Floats,
    count: int,
    progress: Floats,
    plan_interval: float,
    tail_speed: float,
    speed: float,
    ego_length: float,
    ego_width: float,
    deceleration: float,
    poses: Floats,
    length: Floats,
    width: Floats,
    required: Floats,
    end: int,
    interval: float,
) -> float:
    """How good a deceleration is where none keeps clear.

    The least gap [m] where outlines stay apart, otherwise minus the relative speed [m/s] at the first contact.
    """
    own = np.empty((4, 2), dtype=np.float64)
    their = np.empty((4, 2), dtype=np.float64)
    own_radius = 0.5 * math.hypot(ego_length, ego_width)
    least, before = math.inf, 0.0
    for step in range(end + 1):
        position = ego_position(progress, plan_interval, tail_speed, speed, deceleration, step * interval)
        x, y, yaw = pose_on(points, count, position)
        own_speed = (position - before) / interval if step else speed
        before = position
        fill_corners(own, x, y, yaw, ego_length, ego_width)
        for index in range(poses.shape[0]):
            if required[index] < 0.0:
                continue
            their_x, their_y, their_yaw = poses[index, step, 0], poses[index, step, 1], poses[index, step, 2]
            gap = math.hypot(their_x - x, their_y - y) - own_radius - 0.5 * math.hypot(length[index], width[index])
            if gap >= least:
                continue
            fill_corners(their, their_x, their_y, their_yaw, length[index], width[index])
            least = min(least, corner_distance(own, their))
            if least <= 0.0:
                their_speed = poses[index, step, 3]
                return -math.hypot(
                    own_speed * math.cos(yaw) - their_speed * math.cos(their_yaw),
                    own_speed * math.sin(yaw) - their_speed * math.sin(their_yaw),
                )
    return least
