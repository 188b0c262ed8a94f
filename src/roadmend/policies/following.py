"""Laws of longitudinal control: toward an allowed speed, behind a vehicle, up to a line."""

import math

import numpy as np
from numpy.typing import NDArray

from roadmend.core.jit import compiled
from roadmend.policies.path_ahead import PathAhead, speed_on

Record = NDArray[np.void]

HARDEST = 9.0  # [m/s2] no law asks for more
_GENTLE = 3.5  # [m/s2] a follower brakes no harder unless geometry demands it
_SPEED_TIMES = (0.6, 1.5)  # [s] at which the allowed speed ahead is looked up
_LINE_TIME = 0.5  # [s]


@compiled
def needed_deceleration(speed: float, distance: float) -> float:
    """Constant deceleration [m/s2] that stops within a distance [m]."""
    return speed * speed / (2.0 * max(distance, 0.1))


@compiled
def toward_speed(parameters: Record, path: PathAhead, ahead: float, speed: float, most: float) -> float:
    """Acceleration [m/s2] that meets the allowed speed a little further on; at most ``most``.

    Allowed speeds fall along the path no faster than comfortable braking, so looking up one place suffices.
    """
    result = most
    for time in _SPEED_TIMES:
        allowed = speed_on(path, ahead + speed * time)
        result = min(result, (allowed - speed) / time)
    return max(result, -float(parameters[0].deceleration) - 1.5)


@compiled
def behind_vehicle(parameters: Record, speed: float, gap: float, other: float, braking: float, most: float) -> float:
    """Acceleration [m/s2] behind a vehicle at a gap [m] that drives at ``other`` [m/s] and brakes with ``braking``.

    Intelligent driver model (Treiber et al. 2000), limited to gentle braking where the kinematics allow it.
    """
    p = parameters[0]
    soon = max(0.0, other - 0.5 * braking)
    closing = speed - soon
    wanted = p.standstill_gap + max(0.0, speed * p.headway + speed * closing / (2.0 * math.sqrt(most * p.deceleration)))
    room = max(gap, 0.2)
    result = most * (1.0 - (wanted / room) * (wanted / room))
    least = -_GENTLE
    if closing > 0.0:
        # Both may brake on: what counts are the two places of standstill.
        stop = max(room - 0.5 * p.standstill_gap, 0.2)
        if braking > 0.5:
            stop += other * other / (2.0 * braking)
            demand = needed_deceleration(speed, stop)
        else:
            demand = closing * closing / (2.0 * stop)
        if demand > 2.0:
            result = min(result, -demand)
            least = -max(_GENTLE, 1.3 * demand)
    return float(max(result, least, -HARDEST))


@compiled
def up_to_line(parameters: Record, speed: float, distance: float) -> float:
    """Largest acceleration [m/s2] that still lets the ego stop comfortably within a distance [m]."""
    p = parameters[0]
    left = distance - speed * _LINE_TIME
    if left <= 0.0:
        if distance <= 0.0:
            return -max(1.0, min(HARDEST, 2.0 * speed))
        return -max(speed / _LINE_TIME * 0.5, min(HARDEST, needed_deceleration(speed, distance)))
    allowed = math.sqrt(2.0 * p.deceleration * left)
    result = (allowed - speed) / _LINE_TIME
    need = needed_deceleration(speed, distance)
    return min(result, -need) if need > p.deceleration else result
