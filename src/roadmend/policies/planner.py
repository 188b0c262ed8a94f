"""Planner module: a motion along the path that keeps to what was decided and meets nobody."""

import math

import numpy as np
from numpy.typing import NDArray

from roadmend.core.jit import compiled
from roadmend.core.scene import EgoState, Objects
from roadmend.policies import agents as who
from roadmend.policies import behaviour, following, prediction, road
from roadmend.policies.motion_plan import AHEAD, SPEED, Intent, contact, roll
from roadmend.policies.occupancy import HIGH, LOW
from roadmend.policies.path_ahead import PathAhead, pose_ahead
from roadmend.policies.road import RouteTables
from roadmend.policies.situation import Driver, Others, Situation, perceive

Floats = NDArray[np.float64]
Record = NDArray[np.void]

# Caps tried in turn when the plan meets somebody [m/s2]; the positive one is to clear the conflict by speeding up.
_EVASIONS = (-1.0, -2.0, -3.0, 3.0, -4.5, -6.0, -8.0)
_REAR_END = 0.25  # share of the ego's length: who hits it further back than this has run into it from behind
_ENTERED = 1.0  # [m] behind a line from which the front is inside
_HURRY = 3.0  # [m/s2] deceleration beyond which jerk is not limited
_APPLYING = 10.0  # [m/s3] limit of the jerk toward braking
_LETTING_GO = 20.0  # [m/s3] and of the jerk out of it
_STANDING = 0.1  # [m/s]


@compiled
def _first_contact(situation: Situation, plan: Floats) -> int:
    """Index in time at which a plan first meets anybody who matters; TIMES if it meets nobody."""
    p, m = situation.parameters[0], situation.memory[0]
    agents, occupancies = situation.others.agents, situation.others.occupancies
    half = 0.5 * situation.ego.length
    margin = p.time_margin * (2.0 if m.evading > 0.0 else 1.0)
    first = prediction.TIMES
    for index in range(agents.shape[0]):
        if agents[index, who.ROLE] < who.ENTERING or agents[index, who.TRUSTED] > 0.0:
            continue
        ego_index, other_index = contact(
            plan,
            occupancies[index],
            int(agents[index, who.BEGIN]),
            0.0,
            margin,
            half + agents[index, who.CLEARANCE],
            half + 0.3,
        )
        if not 0 <= ego_index < first:
            continue
        if agents[index, who.ROLE] == who.ENTERING:
            low, high = occupancies[index, other_index, LOW], occupancies[index, other_index, HIGH]
            if 0.5 * (low + high) < plan[ego_index, AHEAD] - 2.0 * _REAR_END * half:
                continue
        first = ego_index
    return first


@compiled
def _inside_zone(zones: Floats, memory: Record, half: float) -> bool:
    """Whether the ego's front has entered a conflict zone that its rear has not left: no place to stand."""
    for index in range(zones.shape[0]):
        begin = who.zone_begin(zones, index, memory)
        end = begin + zones[index, road.END] - zones[index, road.BEGIN]
        if begin < math.inf and begin - half < -_ENTERED and end > -half:
            return True
    return False


@compiled
def plan_motion(situation: Situation, intent: Intent, plan: Floats) -> tuple[float, bool]:
    """Fill ``plan`` (TIMES, 2) with the best motion; returns its first acceleration [m/s2] and whether it evades.

    The wanted motion comes first. If it meets somebody, mild to full braking is tried, and speeding up; the first
    that meets nobody is taken, else the one that is slowest at the contact.
    """
    path, parameters, forecasts = situation.path, situation.parameters, situation.others.forecasts
    speed, m = situation.ego.speed, situation.memory[0]
    asked = roll(path, parameters, speed, intent, forecasts, plan)
    met = _first_contact(situation, plan)
    if met >= prediction.TIMES:
        m.evading = 0.0
        return asked, False
    other = np.empty_like(plan)
    half = 0.5 * situation.ego.length
    inside = intent.line == math.inf or _inside_zone(situation.route.zones, situation.memory, half)
    best_asked, slowest = asked, math.inf
    for choice in range(len(_EVASIONS)):
        limit = _EVASIONS[choice]
        if limit > 0.0:
            if not inside:
                continue
            tried_intent = Intent(intent.lead, intent.gap, intent.braking, limit, limit, math.inf)
        else:
            if limit > asked:
                continue
            tried_intent = Intent(intent.lead, intent.gap, intent.braking, intent.most, limit, intent.line)
        tried = roll(path, parameters, speed, tried_intent, forecasts, other)
        met = _first_contact(situation, other)
        at_contact = -1.0 if met >= prediction.TIMES else other[met, SPEED]
        if at_contact < slowest - 0.1:
            slowest, best_asked = at_contact, tried
            plan[:, :] = other
        if at_contact < 0.0:
            break
    m.evading = 1.0
    return best_asked, True


@compiled
def smooth(parameters: Record, memory: Record, asked: float, speed: float, interval: float) -> float:
    """Limit the jerk of the wanted acceleration [m/s2] outside emergencies.

    Brakes are let go of faster than they are applied.
    """
    p, m = parameters[0], memory[0]
    before = max(m.wanted, 0.0) if speed < _STANDING else m.wanted
    result = min(asked, before + (_LETTING_GO if before < 0.0 else p.jerk) * interval)
    if asked > -_HURRY:
        result = max(result, min(before, 0.0) - _APPLYING * interval)
    result = max(result, -following.HARDEST)
    m.wanted = result
    return float(result)


@compiled
def write_trajectory(path: PathAhead, plan: Floats, out: Floats) -> None:
    """Turn the fine part of a plan into x, y, yaw and speed, the rows of ``out`` (4, FINE)."""
    for index in range(prediction.FINE):
        ahead = plan[index + 1, AHEAD]
        out[0, index], out[1, index], out[2, index] = pose_ahead(path, ahead)
        out[3, index] = plan[index + 1, SPEED]


@compiled
def deliberate(
    route: RouteTables,
    driver: Driver,
    ego: EgoState,
    objects: Objects,
    signals: NDArray[np.uint8],
    time: float,
    interval: float,
    trajectory: Floats,
) -> tuple[float, bool, int]:
    """One pass from perception to a plan, ``interval`` [s] after the last: fills ``trajectory`` (4, FINE).

    Returns the wanted acceleration [m/s2], whether to change lane and the word's index. The first three arguments may
    be plain tuples.
    """
    route, driver, ego = RouteTables(*route), Driver(*driver), EgoState(*ego)
    m = driver.memory[0]
    path, tracks = perceive(route, driver, ego, objects, time, interval)
    count = tracks.shape[0]
    forecasts = np.empty((count, prediction.TIMES, prediction.FORECAST_COLUMNS), dtype=np.float64)
    occupancies = np.empty((count, prediction.TIMES, 2), dtype=np.float64)
    others = Others(tracks, forecasts, occupancies, np.empty((count, who.AGENT_COLUMNS), dtype=np.float64))
    situation = Situation(route, path, driver.parameters, driver.memory, signals, ego, others, time, interval)
    who.assess(situation)
    plan = np.empty((prediction.TIMES, 2), dtype=np.float64)
    intent, word, change = behaviour.decide(situation, plan)
    if change:
        m.changing, m.progress, m.change_length, m.change_begin = 1.0, 0.0, 0.0, m.s
    asked, evades = plan_motion(situation, intent, plan)
    if evades:
        word = behaviour.EVADE
        if ego.speed < 0.5:
            m.waited += interval
    write_trajectory(path, plan, trajectory)
    return asked, change, word
