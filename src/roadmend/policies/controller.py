"""Controller module: throttle and brake for a wanted acceleration, by the inverse of a nominal vehicle."""

import numpy as np
from numpy.typing import NDArray

from roadmend.core.jit import compiled

Record = NDArray[np.void]

_STANDING = 0.15  # [m/s]
_COASTING = 0.1  # [m/s2] of force around zero that presses neither pedal


@compiled
def is_held(wanted: float, speed: float) -> bool:
    """Whether the ego stands and is held by the brake, where ``wanted`` [m/s2] is asked for at ``speed`` [m/s]."""
    return speed < _STANDING and wanted <= 0.05


@compiled
def action_for_force(parameters: Record, force: float, speed: float) -> float:
    """The action in [-1, 1] that gives ``force`` [m/s2] at ``speed`` [m/s], by the inverse of a nominal vehicle."""
    p = parameters[0]
    if force > _COASTING:
        return float(min(1.0, force / min(p.engine_acceleration, p.engine_power / max(speed, 1.0))))
    if force < -_COASTING:
        return float(max(-1.0, force / p.full_brake))
    return 0.0


@compiled
def control(parameters: Record, memory: Record, wanted: float, speed: float, interval: float) -> tuple[float, float]:
    """Throttle and brake, each 0..1 and never both, for ``wanted`` [m/s2] at ``speed`` [m/s].

    Knows the vehicle's data sheet and a dry road, not the friction there is. An integral part makes good what the
    model misses; it is frozen while braking hard, where grip and not the model may be the limit.
    """
    p, m = parameters[0], memory[0]
    if is_held(wanted, speed):
        m.correction, m.expected = 0.0, speed
        return 0.0, p.standstill_brake
    missed = m.expected - speed if m.expected >= 0.0 else 0.0
    if abs(missed) < 1.0 and wanted > -2.5:
        m.correction = min(max(m.correction + p.integral_gain * missed * interval, -p.integral_limit), p.integral_limit)
    else:
        m.correction = 0.0
    # What the speed should be at the next tick if the model were right; a lagging actuator stays a little behind.
    m.expected = max(0.0, speed + 0.5 * (wanted + m.last_wanted) * interval)
    m.last_wanted = wanted
    force = wanted + p.drag * speed * speed + p.rolling + m.correction
    action = action_for_force(parameters, force, speed)
    if action > 0.0:
        return action, 0.0
    if action < 0.0:
        return 0.0, -action
    return 0.0, 0.0
