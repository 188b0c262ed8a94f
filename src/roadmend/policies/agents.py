"""Who matters to the ego and in which role: ahead of it, about to enter its path, crossing it, or not at all."""

import math

import numpy as np
from numpy.typing import NDArray

from roadmend.core.jit import compiled
from roadmend.core.route import RightOfWay
from roadmend.core.scene import Signal
from roadmend.policies import following, occupancy, path_ahead, prediction, road
from roadmend.policies.path_ahead import PathAhead
from roadmend.policies.situation import Situation

Floats = NDArray[np.float64]
Record = NDArray[np.void]

# Roles
NOBODY, AHEAD, ENTERING, CROSSING = range(4)
# Columns of the table of agents
# role, row of the zone or -1, 0 or 1, [m] bumper to bumper, time index on the path from, [m] clearance, cosine
ROLE, ZONE, TRUSTED, GAP, BEGIN, CLEARANCE, PARALLEL = range(7)
AGENT_COLUMNS = 7

_STANDING = 0.3  # [m/s]
_ONCOMING_HORIZON = 2.5  # [s] outside conflict zones
_PEDESTRIAN_HORIZON = 2.5  # [s] outside conflict zones
_MERGE_LENGTH = 15.0  # [m] behind a zone's end that belong to the conflict as well
_SHORT_HORIZON = 16  # time index up to which others matter where the ego has to give way to nobody
_STARTING = 0.4  # [m/s2] from which a driver is not about to give way

_YIELD, _STOP = int(RightOfWay.YIELD), int(RightOfWay.STOP)
_SIGNAL, _CROSSING = int(RightOfWay.SIGNAL), int(RightOfWay.CROSSING)
_OFF = int(Signal.OFF)


@compiled
def gives_way(zones: Floats, index: int, signals: NDArray[np.uint8]) -> bool:
    """Whether the ego must give way to vehicles in a zone."""
    rule = int(zones[index, road.RULE])
    if rule == _SIGNAL:
        light = int(zones[index, road.SIGNAL])
        return 0 <= light < signals.shape[0] and int(signals[light]) == _OFF
    return rule in (_YIELD, _STOP)


@compiled
def zone_begin(zones: Floats, index: int, memory: Record) -> float:
    """How far ahead of the ego's centre a zone begins [m]; infinity if it is not on the ego's way now."""
    m = memory[0]
    if zones[index, road.STAGE] == m.stage and m.changing == 0.0:
        return float(zones[index, road.BEGIN] - m.s)
    if zones[index, road.STAGE] == m.stage + 1.0 and m.changing > 0.0:
        return float(zones[index, road.BEGIN] - m.s_next)
    return math.inf


@compiled
def zone_of(
    zones: Floats, memory: Record, signals: NDArray[np.uint8], low: float, high: float, half: float, row: Floats
) -> int:
    """The first zone in which the ego gives way to an object that comes onto its path between two places [m]."""
    for index in range(zones.shape[0]):
        begin = zone_begin(zones, index, memory)
        end = begin + zones[index, road.END] - zones[index, road.BEGIN]
        if begin == math.inf or end < -half:
            continue
        if row[prediction.PEDESTRIAN] > 0.0:
            fits = zones[index, road.RULE] == _CROSSING and high > begin - 1.0 and low < end + 1.0
        else:
            fits = gives_way(zones, index, signals) and high > begin - 2.0 and low < end + _MERGE_LENGTH
        if fits:
            return index
    return -1


@compiled
def _has_to_yield(zones: Floats, memory: Record, signals: NDArray[np.uint8], reach: float, half: float) -> bool:
    """Whether there is a zone within ``reach`` [m] ahead, or around the ego, in which it must give way to anybody."""
    for index in range(zones.shape[0]):
        begin = zone_begin(zones, index, memory)
        near = begin < reach and begin + zones[index, road.END] - zones[index, road.BEGIN] > -half
        if near and (zones[index, road.RULE] == _CROSSING or gives_way(zones, index, signals)):
            return True
    return False


@compiled
def gap_to(path: PathAhead, row: Floats, low: float, high: float, half: float) -> tuple[float, float]:
    """Place of an object's centre along the path [m] and its distance to the ego's front [m], more exactly."""
    points, spacing = path.points, path.spacing
    first = low + 0.5 * spacing
    place = min(max(round((0.5 * (low + high) - first) / spacing), 0), path_ahead.POINTS)
    ahead = first + place * spacing
    # The row of the path that lies there.
    index = min(max(round((ahead + path_ahead.BEHIND) / spacing), 0), path_ahead.POINTS - 1)
    cosine, sine = points[index, path_ahead.COS], points[index, path_ahead.SIN]
    centre = (
        ahead
        + (row[prediction.X] - points[index, path_ahead.X]) * cosine
        + (row[prediction.Y] - points[index, path_ahead.Y]) * sine
    )
    parallel = abs(math.cos(row[prediction.YAW]) * cosine + math.sin(row[prediction.YAW]) * sine)
    across = math.sqrt(max(0.0, 1.0 - parallel * parallel))
    extent = row[prediction.HALF_LENGTH] * parallel + row[prediction.HALF_WIDTH] * across
    return centre, centre - extent - half


@compiled
def assess(situation: Situation) -> None:
    """Fill the forecasts, occupancies and agents of a situation's tracks.

    Who must give way to the ego is trusted to do so as long as braking with parameter ``trust`` would do.
    """
    path, parameters, memory = situation.path, situation.parameters, situation.memory
    zones, signals, ego = situation.route.zones, situation.signals, situation.ego
    tracks, forecasts, occupancies, agents = situation.others
    p, m = parameters[0], memory[0]
    half = 0.5 * ego.length
    patience = min(1.0, m.waited / p.patience)
    cosine, sine = math.cos(ego.yaw), math.sin(ego.yaw)
    yields = _has_to_yield(zones, memory, signals, path_ahead.POINTS * path.spacing, half)
    last = prediction.TIMES - 1 if yields else _SHORT_HORIZON
    for index in range(tracks.shape[0]):
        row, agent = tracks[index], agents[index]
        agent[ROLE], agent[ZONE], agent[TRUSTED], agent[GAP], agent[BEGIN] = NOBODY, -1.0, 0.0, math.inf, -1.0
        agent[CLEARANCE], agent[PARALLEL] = p.front_margin, 0.0
        prediction.forecast(parameters, row, forecasts[index])
        dx, dy = row[prediction.X] - ego.x, row[prediction.Y] - ego.y
        along, aside = dx * cosine + dy * sine, dy * cosine - dx * sine
        behind = along < -half and math.cos(row[prediction.YAW] - ego.yaw) > 0.7
        if behind and (not yields or abs(aside) < 2.0):
            continue  # keeps its own distance
        pedestrian = row[prediction.PEDESTRIAN] > 0.0
        margin = (p.pedestrian_margin if pedestrian else p.side_margin) * (1.0 - 0.8 * patience)
        if pedestrian:
            agent[CLEARANCE] += p.pedestrian_margin
        begin, parallel = occupancy.occupy(path, row, forecasts[index], margin, last, occupancies[index])
        if begin < 0:
            continue
        agent[BEGIN], agent[PARALLEL] = begin, parallel
        low, high = occupancies[index, begin, occupancy.LOW], occupancies[index, begin, occupancy.HIGH]
        zone = zone_of(zones, memory, signals, low, high, half, row)
        agent[ZONE] = zone
        if behind and zone < 0:
            continue
        speed = row[prediction.SPEED]
        if begin == 0:
            centre, gap = gap_to(path, row, low, high, half)
            if centre > 0.0 and (parallel > occupancy.SAME_WAY or speed < _STANDING):
                agent[ROLE], agent[GAP] = AHEAD, gap
                continue
            if centre <= 0.0 and (parallel > occupancy.SAME_WAY or speed < _STANDING):
                continue  # beside or behind, and not coming
        time = prediction.time_at(begin)
        agent[ROLE] = ENTERING if parallel > occupancy.SAME_WAY else CROSSING
        if agent[ROLE] == ENTERING:
            agent[GAP] = low - forecasts[index, begin, prediction.FWAY] - half
        if zone >= 0:
            continue
        if (parallel > occupancy.SAME_WAY and time > p.cut_in_horizon) or (
            parallel < -occupancy.SAME_WAY and time > _ONCOMING_HORIZON
        ):
            agent[ROLE] = NOBODY
        elif pedestrian:
            agent[TRUSTED] = 1.0 if time > _PEDESTRIAN_HORIZON else 0.0
        elif begin > 0:
            left = forecasts[index, begin, prediction.FWAY] - 1.0
            starting = row[prediction.ACCELERATION] > _STARTING and time < 2.5
            if following.needed_deceleration(speed, left) < p.trust and not starting:
                agent[TRUSTED] = 1.0
