"""The formulas of Responsibility-Sensitive Safety (Shalev-Shwartz, Shammah, Shashua 2017, arXiv:1708.06374)."""

from typing import NamedTuple

from roadmend.core.jit import compiled


class Law(NamedTuple):
    """Constants of the formulas."""

    rho: float  # [s]
    accel: float  # [m/s2] a_max,accel
    brake: float  # [m/s2] a_min,brake
    hardest: float  # [m/s2] a_max,brake
    lateral_accel: float  # [m/s2]
    lateral_brake: float  # [m/s2]
    mu: float  # [m]
    time_gap: float  # [s]
    horizon: float  # [s]


@compiled
def stopping_distance(speed: float, law: Law) -> float:
    """Way [m] to standstill: the response time at full acceleration, then the proper response."""
    after = speed + law.rho * law.accel
    return 0.5 * (speed + after) * law.rho + after * after / (2.0 * law.brake)


@compiled
def same_direction(rear: float, front: float, law: Law) -> float:
    """Safe longitudinal distance [m] behind somebody who drives the same way (definition 1), speeds in m/s."""
    return max(0.0, stopping_distance(rear, law) - front * front / (2.0 * law.hardest))


@compiled
def opposite_direction(own: float, other: float, law: Law) -> float:
    """Safe longitudinal distance [m] between two who drive toward each other (definition 3), speeds both >= 0."""
    return stopping_distance(own, law) + stopping_distance(other, law)


@compiled
def lateral(closing: float, law: Law) -> float:
    """Safe lateral distance [m] to somebody who closes in sideways at ``closing`` [m/s] (definition 6).

    The ego itself keeps to its planned path, so its lateral speed is 0. Unlike in the paper, mu and the response
    count only toward those who do close in: something parked beside the path would else be a hazard forever.
    """
    if closing <= 0.05:
        return 0.0
    own = law.rho * law.lateral_accel
    theirs = closing + law.rho * law.lateral_accel
    own_way = 0.5 * own * law.rho + own * own / (2.0 * law.lateral_brake)
    their_way = 0.5 * (closing + theirs) * law.rho + theirs * theirs / (2.0 * law.lateral_brake)
    return law.mu + own_way + their_way
