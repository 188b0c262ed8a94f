"""Behaviour module: what applies now. Whom to follow, where to stop, whether to change lane, and the word for it."""

import math

import numpy as np
from numpy.typing import NDArray

from roadmend.core.jit import compiled
from roadmend.policies import agents as who
from roadmend.policies import following, lane_change, motion_plan, prediction, right_of_way
from roadmend.policies.motion_plan import Intent
from roadmend.policies.situation import Situation

Floats = NDArray[np.float64]
Record = NDArray[np.void]

# What the policy is doing, as an index into WORDS; the first five are the reasons of right_of_way.
WORDS = ("cruise", "signal", "stop", "yield", "crossing", "follow", "merge", "change", "evade")
FOLLOW, MERGE, CHANGE, EVADE = range(5, 9)

_SETTLING = 6.0  # [s] after a change during which the ego still catches up with the traffic
_CUT_IN_BRAKING = 2.5  # [m/s2] hardest braking for somebody who may be about to enter the lane
_SQUEEZE = 1.5  # [m] that the distance to somebody standing across the path shrinks with waiting
_NOTICED = 0.4  # [m/s2] by which a leader must slow the ego to be named


@compiled
def choose_leader(
    parameters: Record, memory: Record, tracks: Floats, agents: Floats, speed: float, most: float
) -> tuple[int, float, float]:
    """Row of the vehicle ahead that asks for most braking (-1: none), its distance [m], and that acceleration [m/s2]."""
    lead, gap, least = -1, math.inf, math.inf
    patience = _SQUEEZE * min(1.0, memory[0].waited / parameters[0].patience)
    for index in range(agents.shape[0]):
        role = agents[index, who.ROLE]
        if role == who.AHEAD or (
            role == who.ENTERING
            and prediction.time_at(int(agents[index, who.BEGIN])) <= parameters[0].cut_in_horizon
            and agents[index, who.ZONE] < 0.0
            and agents[index, who.GAP] > -3.0
        ):
            row = tracks[index]
            other = row[prediction.SPEED]
            braking = max(0.0, -row[prediction.ACCELERATION])
            gap_here = agents[index, who.GAP]
            if agents[index, who.PARALLEL] < 0.5:
                gap_here += patience  # somebody stands across: with time the ego squeezes past
            asked = following.behind_vehicle(parameters, speed, gap_here, other, braking, most)
            if role == who.ENTERING:
                asked = max(asked, -_CUT_IN_BRAKING)
            if asked < least:
                lead, gap, least = index, gap_here, asked
    return lead, gap, least


@compiled
def decide(situation: Situation, plan: Floats) -> tuple[Intent, int, bool]:
    """Decide what the planner has to keep to.

    Returns:
        That, index into WORDS, and whether to begin the lane change now. ``plan`` is used as scratch.
    """
    parameters, memory, speed = situation.parameters, situation.memory, situation.ego.speed
    tracks, forecasts, _, agents = situation.others
    p, m = parameters[0], memory[0]
    merging = m.changing > 0.0 or situation.time - m.changed_at < _SETTLING
    most = p.merging_acceleration if merging else p.acceleration
    lead, gap, least = choose_leader(parameters, memory, tracks, agents, speed, most)
    braking = max(0.0, -tracks[lead, prediction.ACCELERATION]) if lead >= 0 else 0.0
    unhindered = Intent(lead, gap, braking, most, lane_change.NO_CAP, math.inf)
    free = motion_plan.roll(situation.path, parameters, speed, unhindered, forecasts, plan)
    word = 0
    if lead >= 0 and least < free + 0.05 and least < most - _NOTICED:
        word = FOLLOW
    line, reason = right_of_way.stop_line(situation, plan)
    if reason != right_of_way.FREE:
        word = reason
    change, cap, end, sought = lane_change.seek_gap(situation, plan)
    if sought:
        word = MERGE
    blocked = lead >= 0 and agents[lead, who.PARALLEL] < 0.5  # by somebody who stands across
    if speed < 0.5 and reason == right_of_way.FREE and (blocked or (sought and not change)):
        m.waited += situation.interval
    if m.changing > 0.0 or change:
        word = CHANGE
    return Intent(lead, gap, braking, most, cap, min(line, end)), word, change
