"""What the neural policy sees: the ego, the objects near its way, the road ahead and the stop lines, as tokens.

One compiled pass turns a scene into N <= TOKENS rows of COLUMNS numbers. A row has one kind, one-hot in its first
columns, and fills the columns of that kind; all others are zero. Numbers are scaled to about [-3, 3]. They describe
geometry, the rules of the road and motion extrapolated from each object's own; what to do about it is not in them.
"""

import math

import numpy as np
from numpy.typing import NDArray

from roadmend.core.jit import compiled
from roadmend.core.scene import EgoState, ObjectKind, Objects
from roadmend.policies import agents as who
from roadmend.policies import following, motion_plan, path_ahead, prediction, road
from roadmend.policies.motion_plan import Intent
from roadmend.policies.occupancy import HIGH, LOW, SAME_WAY, occupy
from roadmend.policies.parameters import ModularParameters
from roadmend.policies.path_ahead import PathAhead
from roadmend.policies.road import RouteTables
from roadmend.policies.situation import Driver, Others, Situation, pack, perceive

Floats = NDArray[np.float64]
Tokens = NDArray[np.float32]
Record = NDArray[np.void]

OBJECTS = 16  # nearest in time and space; the rest is left out
ZONES = 4
PLACES = (10.0, 22.0, 38.0, 60.0)  # [m] ahead at which the road is described
TOKENS = 1 + OBJECTS + len(PLACES) + ZONES

# First columns of the kinds of token; columns 0 to 3 say which it is
_EGO, _OBJECT, _PLACE, _ZONE = 4, 23, 60, 67
_ROOM = 83  # of the ego: room in the next lane ahead, behind, and the lesser of the two
COLUMNS = 86

# Token and column of all that is the ego's own motion and its road, and says nothing of others or of lights
OWN = tuple((0, column) for column in range(_EGO, _OBJECT)) + tuple(
    (token, column) for token in range(1, 1 + len(PLACES)) for column in range(_PLACE, _ZONE)
)

_STANDING = 0.3  # [m/s]
_ACCELERATION_FILTER = 0.15  # [s]
_AT_LINE = 3.5  # [m] before a line at which standing counts
_FREE_ACCELERATION = 2.2  # [m/s2] of the motion that conflicts are measured against
_NO_CAP = 100.0  # [m/s2]
_LATEST = 9.0  # [s] stands for never
_FASTEST = 80.0  # [m/s] nobody's speed counts as more
_DRIFT_TIME = 1.5  # [s]
_MOTORCYCLE, _BICYCLE = int(ObjectKind.MOTORCYCLE), int(ObjectKind.BICYCLE)

# What is carried from tick to tick
MEMORY: dict[str, float] = {
    "stage": -1.0,
    "s": 0.0,
    "offset": 0.0,
    "s_next": math.nan,
    "offset_next": math.inf,  # localisation
    "changing": 0.0,
    "progress": 0.0,
    "change_length": 0.0,
    "change_begin": 0.0,
    "changed_at": -math.inf,
    "waited": 0.0,
    "stood_at": -1.0,
    "speed": math.nan,
    "acceleration": 0.0,
    "known_count": 0.0,
}


def new_driver(parameters: ModularParameters) -> Driver:
    """What the tokens of an episode begin with."""
    return Driver(parameters.packed(), pack(MEMORY), prediction.nobody_known())


@compiled
def _clip(value: float, low: float, high: float) -> float:
    return min(max(value, low), high)


@compiled
def _remember(memory: Record, zones: Floats, interval: float, speed: float, half: float) -> None:
    """Acceleration, time waited, and the line at which the ego has stood."""
    m = memory[0]
    if math.isnan(m.speed):
        m.speed = speed
    gain = 1.0 - math.exp(-interval / _ACCELERATION_FILTER)
    m.acceleration += gain * (_clip((speed - m.speed) / interval, -10.0, 5.0) - m.acceleration)
    m.speed = speed
    if speed < 0.5:
        m.waited += interval
    elif speed > 3.0:
        m.waited = 0.0
    if speed < _STANDING:
        for index in range(zones.shape[0]):
            front = who.zone_begin(zones, index, memory) - half
            if -0.5 < front < _AT_LINE and m.waited > 0.5:
                m.stood_at = index


@compiled
def _ego(path: PathAhead, stages: Floats, memory: Record, time: float, speed: float, row: Tokens) -> None:
    m = memory[0]
    stage = int(m.stage)
    row[0] = 1.0
    at = _EGO
    row[at] = speed / 10.0
    row[at + 1] = m.acceleration / 3.0
    row[at + 2] = 1.0 if speed < _STANDING else 0.0
    row[at + 3] = min(m.waited / 12.0, 1.5)
    has_next = stage + 1 < stages.shape[0]
    if has_next:
        begin, end = stages[stage, road.WINDOW_BEGIN] - m.s, stages[stage, road.WINDOW_END] - m.s
        row[at + 4] = 1.0
        row[at + 5] = _clip(begin / 50.0, -1.0, 2.0)
        row[at + 6] = _clip(end / 100.0, -0.5, 2.5)
        row[at + 7] = 1.0 if begin <= 0.0 <= end else 0.0
        row[at + 8] = m.changing
        row[at + 9] = m.progress
        row[at + 11] = (
            0.0 if m.changing > 0.0 else _clip(following.needed_deceleration(speed, end - 2.0) / 4.0, 0.0, 3.0)
        )
        row[at + 12] = _clip(end / max(speed, 1.0) / 5.0, -1.0, 3.0)
    row[at + 10] = _clip((time - m.changed_at) / 6.0, 0.0, 1.0)
    row[at + 13] = path_ahead.speed_on(path, 0.0) / 10.0
    for index in range(4):
        seconds = 0.6 * (index + 1) if index < 3 else 4.0
        row[at + 14 + index] = _clip((path_ahead.speed_on(path, speed * seconds) - speed) / seconds / 2.0, -3.0, 3.0)
    row[at + 18] = path.points[int(path_ahead.BEHIND / path.spacing), path_ahead.BEND] * 10.0


@compiled
def _place(path: PathAhead, ahead: float, ego: EgoState, row: Tokens) -> None:
    px, py, heading = path_ahead.pose_ahead(path, ahead)
    cosine, sine = math.cos(ego.yaw), math.sin(ego.yaw)
    dx, dy = px - ego.x, py - ego.y
    allowed = path_ahead.speed_on(path, ahead)
    row[2] = 1.0
    at = _PLACE
    row[at] = (dx * cosine + dy * sine) / 50.0
    row[at + 1] = (dy * cosine - dx * sine) / 20.0
    row[at + 2] = math.cos(heading - ego.yaw)
    row[at + 3] = math.sin(heading - ego.yaw)
    row[at + 4] = allowed / 10.0
    row[at + 5] = (allowed - ego.speed) / 5.0
    nearest = min(int((ahead + path_ahead.BEHIND) / path.spacing), path_ahead.POINTS - 1)
    row[at + 6] = path.points[nearest, path_ahead.BEND] * 10.0


@compiled
def _zone(
    zones: Floats, index: int, memory: Record, signals: NDArray[np.uint8], speed: float, half: float, row: Tokens
) -> None:
    begin = who.zone_begin(zones, index, memory)
    front = begin - half
    length = zones[index, road.END] - zones[index, road.BEGIN]
    row[3] = 1.0
    at = _ZONE
    row[at] = _clip(front / 30.0, -1.0, 3.0)
    row[at + 1] = _clip((begin + length + half) / 30.0, -1.0, 4.0)
    row[at + 2 + int(zones[index, road.RULE])] = 1.0
    light = int(zones[index, road.SIGNAL])
    if 0 <= light < signals.shape[0]:
        row[at + 7 + min(int(signals[light]), 3)] = 1.0
    row[at + 11] = _clip(following.needed_deceleration(speed, front - 0.7) / 4.0, 0.0, 3.0) if front > -0.5 else 0.0
    row[at + 12] = 1.0 if memory[0].stood_at == index else 0.0
    row[at + 13] = _clip(front / max(speed, 1.0) / 4.0, -1.0, 3.0)
    row[at + 14] = 1.0 if front < -0.5 else 0.0
    row[at + 15] = speed / 10.0


@compiled
def _reach(plan: Floats, ahead: float) -> float:
    """Time [s] at which a plan has come ``ahead`` [m]; _LATEST if never."""
    if ahead <= 0.0:
        return 0.0
    for index in range(1, prediction.TIMES):
        if plan[index, motion_plan.AHEAD] >= ahead:
            before = plan[index - 1, motion_plan.AHEAD]
            share = (ahead - before) / max(plan[index, motion_plan.AHEAD] - before, 1e-6)
            earlier = prediction.time_at(index - 1)
            return float(earlier + share * (prediction.time_at(index) - earlier))
    return _LATEST


@compiled
def _object(
    situation: Situation,
    plan: Floats,
    track: Floats,
    forecast: Floats,
    occupancy: Floats,
    kind: int,
    row: Tokens,
) -> float:
    """Fill one object's token; returns how little it matters. ``occupancy`` is used as scratch."""
    path, ego, speed, half = situation.path, situation.ego, situation.ego.speed, 0.5 * situation.ego.length
    samples, stages, zones = situation.route
    p, m = situation.parameters[0], situation.memory[0]
    at = _OBJECT
    row[:] = 0.0
    row[1] = 1.0
    cosine, sine = math.cos(ego.yaw), math.sin(ego.yaw)
    dx, dy = track[prediction.X] - ego.x, track[prediction.Y] - ego.y
    along, aside = dx * cosine + dy * sine, dy * cosine - dx * sine
    turn = track[prediction.YAW] - ego.yaw
    v = min(track[prediction.SPEED], _FASTEST)
    pedestrian = track[prediction.PEDESTRIAN] > 0.0
    row[at] = _clip(along / 30.0, -3.0, 3.0)
    row[at + 1] = _clip(aside / 10.0, -3.0, 3.0)
    row[at + 2] = math.cos(turn)
    row[at + 3] = math.sin(turn)
    row[at + 4] = v / 10.0
    row[at + 5] = (v * math.cos(turn) - speed) / 10.0
    row[at + 6] = v * math.sin(turn) / 5.0
    row[at + 7] = track[prediction.ACCELERATION] / 3.0
    row[at + 8] = track[prediction.CURVATURE] * 10.0
    row[at + 9] = min(track[prediction.HALF_LENGTH] / 3.0, 5.0)
    row[at + 10] = min(track[prediction.HALF_WIDTH], 5.0)
    row[at + 11] = 1.0 if kind in (_MOTORCYCLE, _BICYCLE) else 0.0
    row[at + 12] = 1.0 if pedestrian else 0.0
    row[at + 13] = speed / 10.0
    row[at + 36] = 1.0 if v > _STANDING else 0.0
    unimportance = math.hypot(along, aside) / 10.0 + 4.0
    if along < -half and abs(aside) < 2.0 and math.cos(turn) > 0.7:
        unimportance += 4.0
    margin = p.pedestrian_margin if pedestrian else p.side_margin
    begin, parallel = occupy(path, track, forecast, margin, prediction.TIMES - 1, occupancy)
    if begin >= 0:
        low, high = occupancy[begin, LOW], occupancy[begin, HIGH]
        entry = prediction.time_at(begin)
        leave = _LATEST
        if not (begin == 0 and parallel > SAME_WAY):  # who goes the ego's way is not followed further
            for index in range(begin + 1, prediction.TIMES):
                if occupancy[index, HIGH] < occupancy[index, LOW]:
                    leave = prediction.time_at(index)
                    break
        reach, clear = _reach(plan, low - half), _reach(plan, high + half)
        row[at + 14] = 1.0 if begin == 0 else 0.0
        row[at + 15] = 1.0
        row[at + 16] = entry / 4.0
        row[at + 17] = leave / 4.0
        row[at + 18] = _clip(low / 30.0, -1.0, 3.0)
        row[at + 19] = parallel
        gap = low + 0.5 * path.spacing - half
        if begin == 0 and high > 0.0:
            # The exact gap: the place of the centre along the path, less both half lengths.
            gap, _ = who.gap_to(path, track, low, high, half)
            closing = max(0.0, speed - v * max(parallel, 0.0))
            stop = max(gap - 1.2, 0.2)
            row[at + 20] = _clip(gap / 20.0, -0.5, 3.0)
            row[at + 21] = _clip(closing * closing / (2.0 * stop) / 4.0, 0.0, 3.0)
            row[at + 22] = _clip(gap / max(speed, 1.0) / 2.0, -0.5, 3.0)
            row[at + 23] = 1.0
        row[at + 24] = reach / 4.0
        row[at + 25] = _clip((entry - clear) / 3.0, -2.0, 2.0)
        row[at + 26] = _clip((reach - leave) / 3.0, -2.0, 2.0)
        row[at + 27] = _clip(following.needed_deceleration(speed, gap - 1.0) / 4.0, 0.0, 3.0) if gap > 0.0 else 0.0
        zone = who.zone_of(zones, situation.memory, situation.signals, low, high, half, track)
        row[at + 28] = 1.0 if zone >= 0 else 0.0
        wide, _ = motion_plan.contact(plan, occupancy, begin, 0.5, 1.2, half + 1.0, half + 0.3)
        close, _ = motion_plan.contact(plan, occupancy, begin, 0.0, 0.3, half + 0.6, half + 0.3)
        row[at + 29] = 1.0 - prediction.time_at(wide) / 10.0 if wide >= 0 else 0.0
        row[at + 30] = 1.0 - prediction.time_at(close) / 10.0 if close >= 0 else 0.0
        if high > -half:
            unimportance -= 5.0
    stage = int(m.stage) + 1
    if stage < stages.shape[0] and m.changing == 0.0:
        first, count = int(stages[stage, road.FIRST]), int(stages[stage, road.COUNT])
        s, offset = road.project_on(samples, first, count, track[prediction.X], track[prediction.Y], m.s_next, 200.0)
        _, _, lane_cosine, lane_sine, _, _ = road.pose_on(samples, first, count, s)
        other_cosine, other_sine = math.cos(track[prediction.YAW]), math.sin(track[prediction.YAW])
        drift = v * (other_sine * lane_cosine - other_cosine * lane_sine) * _DRIFT_TIME
        room = track[prediction.HALF_WIDTH] + 0.5 * ego.width + 0.2
        there = min(abs(offset), abs(offset + drift)) < room or offset * (offset + drift) < 0.0
        place = s - m.s_next
        free = abs(place) - track[prediction.HALF_LENGTH] - half
        row[at + 31] = 1.0 if there else 0.0
        row[at + 32] = _clip(place / 30.0, -3.0, 3.0)
        row[at + 33] = _clip(offset / 3.0, -3.0, 3.0)
        if there:
            if place >= 0.0:
                closing = max(0.0, speed - v)
                need = 2.5 + 0.4 * speed + closing * closing / 5.0
            else:
                closing = max(0.0, v - speed)
                need = 2.5 + 0.5 * v + 0.6 * closing + closing * closing / 5.4
            row[at + 34] = _clip((free - need) / 10.0, -3.0, 3.0)
            row[at + 35] = _clip(free / max(need, 1.0) - 1.0, -2.0, 2.0)
            unimportance -= 3.0
    return unimportance


@compiled
def _fill_room(tokens: Tokens, count: int) -> None:
    """The room in the next lane, as the tightest of the objects' shares (free gap to needed gap, less one)."""
    ahead, behind = 2.0, 2.0
    for index in range(1, count):
        if tokens[index, _OBJECT + 31] > 0.0:
            if tokens[index, _OBJECT + 32] >= 0.0:
                ahead = min(ahead, float(tokens[index, _OBJECT + 35]))
            else:
                behind = min(behind, float(tokens[index, _OBJECT + 35]))
    tokens[0, _ROOM], tokens[0, _ROOM + 1], tokens[0, _ROOM + 2] = ahead, behind, min(ahead, behind)


@compiled
def tokenise(
    route: RouteTables,
    driver: Driver,
    ego: EgoState,
    objects: Objects,
    signals: NDArray[np.uint8],
    clock: tuple[float, float],
    tokens: Tokens,
    sources: NDArray[np.int64],
) -> tuple[int, Floats, float]:
    """Fill ``tokens`` (TOKENS, COLUMNS) from a scene; returns how many there are, and the parts of the path ahead.

    ``clock`` holds the time and the interval since the last scene [s]. ``sources`` (TOKENS,) receives the row of each
    token's object in the scene, -1 for the other kinds. The ego's token comes first, then the places, the zones and
    the objects, those that matter most before the others.
    """
    time, interval = clock
    route, driver, ego = RouteTables(*route), Driver(*driver), EgoState(*ego)
    parameters, memory, zones = driver.parameters, driver.memory, route.zones
    speed, half = ego.speed, 0.5 * ego.length
    path, tracks = perceive(route, driver, ego, objects, time, interval)
    _remember(memory, zones, interval, speed, half)
    tokens[:, :] = 0.0
    sources[:] = -1
    _ego(path, route.stages, memory, time, speed, tokens[0])
    count = 1
    for ahead in PLACES:
        _place(path, ahead, ego, tokens[count])
        count += 1
    for index in range(zones.shape[0]):
        begin = who.zone_begin(zones, index, memory)
        over = begin + zones[index, road.END] - zones[index, road.BEGIN] < -half
        if begin < 90.0 and not over and count < 1 + len(PLACES) + ZONES:
            _zone(zones, index, memory, signals, speed, half, tokens[count])
            count += 1
    plan = np.empty((prediction.TIMES, 2), dtype=np.float64)
    forecast = np.empty((prediction.TIMES, prediction.FORECAST_COLUMNS), dtype=np.float64)
    occupancy = np.empty((prediction.TIMES, 2), dtype=np.float64)
    nobody = np.empty((0, prediction.TIMES, prediction.FORECAST_COLUMNS), dtype=np.float64)
    free = Intent(-1, math.inf, 0.0, _FREE_ACCELERATION, _NO_CAP, math.inf)
    motion_plan.roll(path, parameters, speed, free, nobody, plan)
    others = Others(tracks, nobody, nobody, np.empty((0, who.AGENT_COLUMNS), dtype=np.float64))
    situation = Situation(route, path, parameters, memory, signals, ego, others, time, interval)
    rows = np.empty((tracks.shape[0], COLUMNS), dtype=np.float32)
    unimportance = np.empty(tracks.shape[0], dtype=np.float64)
    for index in range(tracks.shape[0]):
        prediction.forecast(parameters, tracks[index], forecast)
        kind = int(objects[int(tracks[index, prediction.SOURCE])].kind)
        unimportance[index] = _object(situation, plan, tracks[index], forecast, occupancy, kind, rows[index])
    order = np.argsort(unimportance, kind="mergesort")
    for place in range(min(order.shape[0], OBJECTS)):
        tokens[count] = rows[order[place]]
        sources[count] = int(tracks[order[place], prediction.SOURCE])
        count += 1
    if tokens[0, _EGO + 4] > 0.0 and memory[0].changing == 0.0:
        _fill_room(tokens, count)
    return count, path.points, path.spacing


def may_change(tokens: Tokens) -> bool:
    """Whether the ego is inside the window of its next lane change and not changing, by its token."""
    return bool(tokens[0, _EGO + 7] > 0.0 and tokens[0, _EGO + 8] == 0.0)
