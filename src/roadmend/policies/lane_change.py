"""When to change to the next lane of the route, and how to reach the gap for it."""

import math

import numpy as np
from numpy.typing import NDArray

from roadmend.core.jit import compiled
from roadmend.policies import following, prediction, road
from roadmend.policies.path_ahead import speed_on
from roadmend.policies.road import RouteTables
from roadmend.policies.situation import Situation

Floats = NDArray[np.float64]
Record = NDArray[np.void]

NO_CAP = 100.0  # [m/s2]
_LOOK_AHEAD = 5.0  # [s] before the window at which the search begins
_DRIFT_TIME = 1.5  # [s] of sideways motion after which others count to the lane they move to
_OWN_ACCELERATION = 1.2  # [m/s2] that the ego gains on those behind after a change
_REACTION = 0.6  # [s] of those behind
_URGENT = 4.0  # [s] before the end of the window at which margins begin to shrink
_SMALLEST = 0.45  # share of the margins that always stays
_LINE_MARGIN = 2.0  # [m] before the end of the window
_TRIED = (0.0, 1.5, -1.0, -2.0, -3.0)  # [m/s2] constant accelerations with which gaps are looked for; 0: as planned

# Columns of the table of those in the other lane
_TRACK, _PLACE, _HALF = range(3)  # row of the track, [m] ahead of the ego there, [m]


@compiled
def _neighbours(route: RouteTables, memory: Record, tracks: Floats, half_width: float) -> Floats:
    """Who is on the next stage's lane, or on its straight extension backwards, or moves there."""
    m, samples, stages = memory[0], route.samples, route.stages
    out = np.empty((tracks.shape[0], 3), dtype=np.float64)
    stage = int(m.stage) + 1
    first, count = int(stages[stage, road.FIRST]), int(stages[stage, road.COUNT])
    found = 0
    for index in range(tracks.shape[0]):
        row = tracks[index]
        s, offset = road.project_on(samples, first, count, row[prediction.X], row[prediction.Y], m.s_next, 200.0)
        _, _, lane_cosine, lane_sine, _, _ = road.pose_on(samples, first, count, s)
        cosine, sine = math.cos(row[prediction.YAW]), math.sin(row[prediction.YAW])
        if row[prediction.SPEED] > 0.5 and cosine * lane_cosine + sine * lane_sine < 0.3:
            continue
        drift = row[prediction.SPEED] * (sine * lane_cosine - cosine * lane_sine) * _DRIFT_TIME
        reach = row[prediction.HALF_WIDTH] + half_width + 0.2
        if min(abs(offset), abs(offset + drift)) < reach or offset * (offset + drift) < 0.0:
            out[found, _TRACK], out[found, _PLACE], out[found, _HALF] = index, s - m.s_next, row[prediction.HALF_LENGTH]
            found += 1
    return out[:found]


@compiled
def _fits(
    parameters: Record,
    neighbours: Floats,
    forecasts: Floats,
    time: int,
    ahead: float,
    speed: float,
    half: float,
    share: float,
) -> bool:
    """Whether the ego can change at a time index, being ``ahead`` [m] of its present place at ``speed`` [m/s]."""
    p = parameters[0]
    for index in range(neighbours.shape[0]):
        forecast = forecasts[int(neighbours[index, _TRACK]), time]
        apart = neighbours[index, _PLACE] + forecast[prediction.FWAY] - ahead
        other = forecast[prediction.FSPEED]
        gap = abs(apart) - neighbours[index, _HALF] - half
        if apart >= 0.0:
            closing = max(0.0, speed - other)
            need = (
                p.change_gap + p.change_front_headway * speed + closing * closing / (2.0 * p.change_front_deceleration)
            )
        else:
            closing = max(0.0, other - speed)
            ease = p.change_rear_deceleration + _OWN_ACCELERATION
            need = p.change_gap + p.change_rear_headway * other + _REACTION * closing + closing * closing / (2.0 * ease)
        if gap < need * share:
            return False
    return True


@compiled
def seek_gap(situation: Situation, plan: Floats) -> tuple[bool, float, float, bool]:
    """Whether to change now, a cap on the acceleration [m/s2], a line to stop at [m ahead], and whether one is sought.

    Gaps are looked for along the ``plan`` and under constant accelerations, at every half second and beyond 5 s at
    every second; the earliest and gentlest is taken. Without any the ego slows down for the end of the window, never
    past it.
    """
    parameters, memory, stages = situation.parameters, situation.memory, situation.route.stages
    forecasts, speed, half = situation.others.forecasts, situation.ego.speed, 0.5 * situation.ego.length
    p, m = parameters[0], memory[0]
    stage = int(m.stage)
    if m.changing > 0.0 or stage + 1 >= stages.shape[0]:
        return False, NO_CAP, math.inf, False
    begin, end = stages[stage, road.WINDOW_BEGIN] - m.s, stages[stage, road.WINDOW_END] - m.s
    if begin > speed * _LOOK_AHEAD + 20.0:
        return False, NO_CAP, math.inf, False
    neighbours = _neighbours(situation.route, memory, situation.others.tracks, 0.5 * situation.ego.width)
    urgent = 1.0 - 0.4 * min(1.0, max(0.0, 1.0 - end / max(speed, 1.0) / _URGENT))
    share = max(_SMALLEST, urgent * (1.0 - 0.5 * min(1.0, m.waited / p.patience)))
    inside = begin <= 0.0 <= end
    if inside and _fits(parameters, neighbours, forecasts, 0, 0.0, speed, half, share):
        return True, NO_CAP, math.inf, True
    fastest = max(speed_on(situation.path, 0.0), speed)
    best_cost, best_cap, best_time = math.inf, NO_CAP, math.inf
    for choice in range(len(_TRIED)):
        acceleration = _TRIED[choice]
        for time in range(2, prediction.index_before(p.change_horizon) + 1, 2):
            seconds = prediction.time_at(time)
            if choice == 0:
                ahead, then = plan[time, 0], plan[time, 1]
            else:
                then = min(max(speed + acceleration * seconds, 0.0), fastest)
                lasted = (then - speed) / acceleration if acceleration != 0.0 else 0.0
                ahead = 0.5 * (speed + then) * lasted + then * max(0.0, seconds - lasted)
            if ahead > end:
                break
            if acceleration > 0.0 and ahead > plan[time, 0] + 0.5:
                break  # the plan is slower for a reason
            if ahead < begin:
                continue
            if _fits(parameters, neighbours, forecasts, time, ahead, then, half, share):
                cost = seconds + 0.8 * max(0.0, -acceleration)
                if cost < best_cost:
                    best_cost, best_time = cost, seconds
                    best_cap = acceleration if acceleration < 0.0 else NO_CAP
                break
    place = end - _LINE_MARGIN
    if best_time == math.inf or (following.needed_deceleration(speed, place) > 3.0 and best_time > 1.5 and inside):
        return False, best_cap, place, True
    return False, best_cap, math.inf, True
