"""Turns whatever arrives into something a method can work with, always toward braking."""

import math

import numpy as np
from numpy.typing import NDArray

from roadmend.core.command import Command, Trajectory
from roadmend.core.jit import compiled
from roadmend.core.route import FAR
from roadmend.core.scene import EgoState, Objects

Floats = NDArray[np.float64]

LATE = 1e6  # [s] no plan looks as far ahead, and points much later than that have no stamp
SHORT = 1e-3  # [s] no plan needs its points nearer to each other, and far nearer ones cannot be counted
MANY = 600  # points of a plan; a planned path has no room for many more
WILD = 1e4  # accelerations [m/s2], yaw rates [rad/s] and yaws [rad] beyond this are noise


def sanitise_command(command: Command, stop_brake: float) -> Command:
    """The valid command nearest to what was asked that never accelerates more under any reading of it.

    - NaN in a pedal, or an infinite throttle, is as good as no command: throttle 0, the brake of a controlled stop
      or the brake that was asked for if that is harder, no lane change.
    - A throttle above 1 is 1. A throttle below 0 is a wish to slow down: throttle 0, brake at least its magnitude.
    - A brake above 1, or infinite, is 1. A brake below 0 is 0.
    - With both pedals pressed the throttle is dropped.

    Args:
        command: what the policy asked for.
        stop_brake: brake of a controlled stop, 0 .. 1.
    """
    throttle, brake = command.throttle, command.brake
    if math.isnan(brake) or not math.isfinite(throttle):
        asked = 0.0 if math.isnan(brake) else min(1.0, brake)
        return Command(0.0, max(stop_brake, asked))
    brake = min(1.0, max(0.0, brake))
    if throttle < 0.0:
        return Command(0.0, max(brake, min(1.0, -throttle)), command.change_lane)
    if brake > 0.0:
        return Command(0.0, brake, command.change_lane)
    return Command(min(1.0, throttle), 0.0, command.change_lane)


def is_usable_ego(ego: EgoState, time: float) -> bool:
    """Whether the odometry and the stamp are finite and the ego has a size."""
    total = time + ego.x + ego.y + ego.yaw + ego.speed + ego.yaw_rate + ego.length + ego.width
    return math.isfinite(total) and abs(ego.x) < FAR and abs(ego.y) < FAR and ego.length > 0.0 and ego.width > 0.0


@compiled
def is_usable_plan(interval: float, x: Floats, y: Floats, yaw: Floats, speed: Floats) -> bool:
    """Whether a trajectory has equally long arrays of up to 600 points, only finite values and an end in sight.

    Its interval is 1 ms or more.
    """
    size = x.shape[0]
    if y.shape[0] != size or yaw.shape[0] != size or speed.shape[0] != size:
        return False
    if size > MANY or not SHORT <= interval < LATE / max(size, 1):
        return False
    for index in range(size):
        if not (abs(x[index]) < FAR and abs(y[index]) < FAR and abs(yaw[index]) < WILD and abs(speed[index]) < WILD):
            return False
    return True


def usable_plan(plan: Trajectory) -> Trajectory:
    """The plan, or one without points in the place of an unusable one."""
    is_usable = is_usable_plan(plan.interval, plan.x, plan.y, plan.yaw, plan.speed)
    return plan if is_usable else Trajectory.empty()


@compiled
def mark_usable(
    keep: NDArray[np.bool_], objects: Objects, max_length: float, max_width: float, max_speed: float
) -> int:
    """Mark in ``keep`` which of N objects can be used; returns how many cannot.

    Unusable is what has a value that is not finite or out of all reason, no size, or the id of a usable object that
    stands before it in the list.
    """
    size = objects.shape[0]
    slots = 16
    while slots < 2 * size:
        slots *= 2
    seen = np.full(slots, -1, dtype=np.int64)  # open addressing: linear in N, however long the list is
    dropped = 0
    for index in range(size):
        one = objects[index]
        keep[index] = (
            abs(one.x) < FAR
            and abs(one.y) < FAR
            and abs(one.yaw) < WILD
            and abs(one.speed) <= max_speed
            and abs(one.acceleration) < WILD
            and abs(one.yaw_rate) < WILD
            and 0.0 < one.length <= max_length
            and 0.0 < one.width <= max_width
        )
        if keep[index]:
            key = np.int64(one.id)
            slot = (key * 2654435761) & (slots - 1)
            while seen[slot] >= 0:
                if seen[slot] == key:
                    keep[index] = False
                    break
                slot = (slot + 1) & (slots - 1)
            seen[slot] = key
        if not keep[index]:
            dropped += 1
    return dropped
