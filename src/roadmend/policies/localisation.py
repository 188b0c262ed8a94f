"""Localisation module: where on its route the ego is, and how far a lane change has come."""

import math

import numpy as np
from numpy.typing import NDArray

from roadmend.core.jit import compiled
from roadmend.core.scene import EgoState
from roadmend.policies import road
from roadmend.policies.road import RouteTables

Record = NDArray[np.void]

_REACH = 30.0  # [m] around the last known place
_LOST = 6.0  # [m] offset beyond which the last known place is not believed
_NOT_BEGUN = 0.02  # share of the lateral way below which a change has not begun


@compiled
def _find(route: RouteTables, ego: EgoState) -> tuple[int, float, float]:
    """Stage, arc length [m] and offset [m] of the nearest stage, without any earlier knowledge."""
    stages = route.stages
    best, best_s, best_offset, least = 0, 0.0, math.inf, math.inf
    for stage in range(stages.shape[0]):
        first, count = int(stages[stage, road.FIRST]), int(stages[stage, road.COUNT])
        length = stages[stage, road.LENGTH]
        s, offset = road.project_on(route.samples, first, count, ego.x, ego.y, 0.5 * length, length)
        away = abs(offset) + max(-s, s - length, 0.0)  # a lane that has ended may lie in line with one that goes on
        if away < least - 1e-9:
            best, best_s, best_offset, least = stage, s, offset, away
    return best, best_s, best_offset


@compiled
def _look_across(route: RouteTables, memory: Record, stage: int, ego: EgoState, around: float) -> None:
    """Set s_next and offset_next: the ego's place on the next stage, searched near ``around`` [m] if that is finite."""
    m, stages = memory[0], route.stages
    m.s_next, m.offset_next = math.nan, math.inf
    if stage + 1 < stages.shape[0]:
        first, count = int(stages[stage + 1, road.FIRST]), int(stages[stage + 1, road.COUNT])
        length = stages[stage + 1, road.LENGTH]
        reach = _REACH if math.isfinite(around) else length
        middle = around if math.isfinite(around) else 0.5 * length
        m.s_next, m.offset_next = road.project_on(route.samples, first, count, ego.x, ego.y, middle, reach)


@compiled
def share_of_change(weight: float) -> float:
    """The progress in 0..1 at which the quintic blend 10u3 - 15u4 + 6u5 has a weight in 0..1."""
    low, high = 0.0, 1.0
    for _ in range(24):
        middle = 0.5 * (low + high)
        if middle * middle * middle * (10.0 + middle * (-15.0 + 6.0 * middle)) < weight:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@compiled
def localise(route: RouteTables, parameters: Record, memory: Record, ego: EgoState) -> None:
    """Bring ``memory`` up to date with the ego's position and speed.

    Sets stage, s, offset and, where the route has a next stage, s_next and offset_next; changing and progress say
    whether a lane change is under way and which share of it is done. Everything but the length of the change follows
    from geometry, so that a policy which starts in the middle of an episode finds its place.
    """
    p, m, stages = parameters[0], memory[0], route.stages
    stage = int(m.stage)
    known = stage >= 0
    s, offset = 0.0, math.inf
    if known:
        first, count = int(stages[stage, road.FIRST]), int(stages[stage, road.COUNT])
        s, offset = road.project_on(route.samples, first, count, ego.x, ego.y, m.s, _REACH)
    if not known or abs(offset) > _LOST:
        stage, s, offset = _find(route, ego)
        m.changing, m.progress, m.change_length, m.s_next = 0.0, 0.0, 0.0, math.nan  # search everywhere
    _look_across(route, memory, stage, ego, m.s_next)
    if stage + 1 < stages.shape[0]:
        begun = s >= stages[stage, road.WINDOW_BEGIN] - 1.0
        if begun and abs(m.offset_next) < p.arrival_offset and abs(m.offset_next) < abs(offset):
            stage, s, offset = stage + 1, m.s_next, m.offset_next
            m.changing, m.progress = 0.0, 0.0
            _look_across(route, memory, stage, ego, math.nan)
        elif begun:
            _follow_change(parameters, memory, s, offset, ego.speed)
    m.stage, m.s, m.offset = stage, s, offset


@compiled
def _follow_change(parameters: Record, memory: Record, s: float, offset: float, speed: float) -> None:
    """How far the change has come, from the share of the lateral way that is behind the ego."""
    p, m = parameters[0], memory[0]
    apart = abs(offset) + abs(m.offset_next)
    weight = abs(offset) / apart if apart > 0.5 else 0.0
    if m.changing == 0.0 and abs(offset) > p.arrival_offset and weight > _NOT_BEGUN:
        m.changing, m.change_length = 1.0, 0.0  # seen, not commanded: the policy has been started again
    if m.changing == 0.0:
        return
    if m.change_length <= 0.0:
        m.change_length = max(p.change_length_min, p.change_time * speed)
        m.change_begin = s - share_of_change(weight) * m.change_length
    driven = (s - m.change_begin) / m.change_length
    if driven > 0.35 and weight < _NOT_BEGUN:
        m.changing, m.progress, m.change_length = 0.0, 0.0, 0.0  # the command was not obeyed
        return
    m.progress = share_of_change(weight)
