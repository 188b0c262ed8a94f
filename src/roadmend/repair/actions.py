"""The repair action space of the paper (ADReFT section 3.1.3): ten bins from 0.8 down to -1.0, step 0.2."""

import math

ACTIONS = tuple(round(0.8 - 0.2 * index, 1) for index in range(10))  # throttle - brake


def braking_action(deceleration: float, full_brake: float) -> float:
    """The mildest bin at or below zero that brakes with at least ``deceleration`` [m/s2].

    Args:
        deceleration: what is needed [m/s2]; whatever exceeds the vehicle's means gives the strongest bin.
        full_brake: deceleration of the vehicle at brake 1 [m/s2].
    """
    if deceleration >= full_brake:
        return -1.0
    bins = math.ceil(5.0 * deceleration / full_brake - 1e-9)
    return round(-0.2 * bins, 1) if bins > 0 else 0.0
