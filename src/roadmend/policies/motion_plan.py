"""A plan over time: where the ego will be on its path under the laws of following, and whom it would meet."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from roadmend.core.jit import compiled
from roadmend.policies import following, prediction
from roadmend.policies.occupancy import HIGH, LOW
from roadmend.policies.path_ahead import PathAhead

Floats = NDArray[np.float64]
Record = NDArray[np.void]

# Columns of a plan of shape (TIMES, 2)
AHEAD, SPEED = range(2)  # [m] of the centre from where it is now, [m/s]


class Intent(NamedTuple):
    """What a motion has to keep to."""

    lead: int  # row of the vehicle to follow, -1: nobody
    gap: float  # [m] to it
    braking: float  # [m/s2] of it
    most: float  # [m/s2] acceleration on a free road
    cap: float  # [m/s2] upper limit on top of every law
    line: float  # [m] ahead where the ego's centre must stop; inf: nowhere


@compiled
def roll(path: PathAhead, parameters: Record, speed: float, intent: Intent, forecasts: Floats, out: Floats) -> float:
    """Fill ``out`` with the motion that keeps to speeds and to an intent; returns its first acceleration [m/s2]."""
    lead, most, line = intent.lead, intent.most, intent.line
    ahead, v, asked = 0.0, speed, 0.0
    out[0, AHEAD], out[0, SPEED] = 0.0, speed
    for index in range(1, prediction.TIMES):
        interval = prediction.FINE_INTERVAL if index <= prediction.FINE else prediction.COARSE_INTERVAL
        wanted = following.toward_speed(parameters, path, ahead, v, most)
        if line < 1e6:
            wanted = min(wanted, following.up_to_line(parameters, v, line - ahead))
        if lead >= 0:
            before = forecasts[lead, index - 1]
            gap = intent.gap + before[prediction.FWAY] - ahead
            braking = intent.braking if index == 1 else 0.0
            wanted = min(wanted, following.behind_vehicle(parameters, v, gap, before[prediction.FSPEED], braking, most))
        wanted = min(wanted, intent.cap)
        if index == 1:
            asked = wanted
        after = max(0.0, v + wanted * interval)
        ahead += 0.5 * (v + after) * interval
        v = after
        out[index, AHEAD], out[index, SPEED] = ahead, v
    return asked


@compiled
def contact(
    plan: Floats, occupancy: Floats, first: int, before: float, after: float, front: float, rear: float
) -> tuple[int, int]:
    """First index in time at which a plan meets an object, and the object's index in time there; -1, -1 if never.

    The object is on the path from index ``first`` on and counts from ``after`` [s] later back to ``before`` [s]
    earlier than the ego is there. ``front`` and ``rear`` [m] are how far the ego and its clearance reach from its
    centre.
    """
    for index in range(prediction.TIMES):
        time = prediction.time_at(index)
        low = plan[index, AHEAD] - rear
        high = plan[index, AHEAD] + front
        begin = prediction.index_before(max(0.0, time - before) + 1e-9)
        end = prediction.index_before(time + after + 1e-9)
        for other in range(max(begin, first), end + 1):
            if occupancy[other, LOW] < high and occupancy[other, HIGH] > low:
                return index, other
    return -1, -1
