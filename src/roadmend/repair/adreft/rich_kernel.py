"""Fills the rich tokens of one tick: see ``rich_tokens`` for what they mean."""

import math

import numpy as np
from numpy.typing import NDArray

from roadmend.core.geometry import corner_distance, fill_corners, wrap_angle
from roadmend.core.jit import compiled
from roadmend.repair.conflict import shared_ground
from roadmend.repair.path import coordinates_on, planned_position, planned_time, pose_on
from roadmend.repair.rollout import ego_position, roll_object

Floats = NDArray[np.float64]
Tokens = NDArray[np.float32]

STEPS = 24  # of the forecast
INTERVAL = 0.2  # [s] between them
HORIZON = STEPS * INTERVAL  # [s]
NEAR = 4.0  # [m] gaps in the forecast beyond this count as this
CONFLICT = 8.0  # [s] times to a conflict area beyond this count as this
MANNERS = 4  # the ego as planned, as planned with objects that keep accelerating, braking with 3.2, with 8 m/s2
PLAN_TOKENS = 8
PLAN_INTERVAL = 0.5  # [s] between two trajectory tokens
LIMIT = 12.0  # no value lies farther from zero; those of a scene that can be are all within
ZONE_REACH = 60.0  # [m] zones farther ahead than this count as this far

# Columns. The first three tell the categories apart; every category uses the rest as it needs.
PARTICIPANT, POINT, EGO = 0, 1, 2
X, Y, COS, SIN, LENGTH, WIDTH = 3, 4, 5, 6, 7, 8
VELOCITY_X, VELOCITY_Y, SPEED, ACCELERATION, YAW_RATE, VULNERABLE, BEHIND = 9, 10, 11, 12, 13, 14, 15
ALONG, ASIDE, TURNED_COS, TURNED_SIN, GAP = 16, 17, 18, 19, 20
FORECAST = 21  # MANNERS pairs of least gap and its time
ENTER, THEY_ENTER, THEY_LEAVE = 29, 30, 31
ATTRIBUTES = 32
# The ego's token has these instead from column 16 on.
ACTION, EGO_ACCELERATION, STOOD, ZONE_BEGIN, ZONE_END, ZONE_INSIDE, ZONE_RULE, ZONE_HALT = (
    16,
    17,
    18,
    19,
    20,
    21,
    22,
    27,
)
STAGE_CHANGE = 28


@compiled
def bound(tokens: Tokens) -> None:
    """Bring every value into -LIMIT .. LIMIT: an absurd plan or speed must not swamp the model; NaN counts as LIMIT."""
    for number in range(tokens.shape[0]):
        for column in range(tokens.shape[1]):
            value = tokens[number, column]
            if not value < LIMIT:
                tokens[number, column] = LIMIT
            elif value < -LIMIT:
                tokens[number, column] = -LIMIT


@compiled
def _forecast(
    row: Tokens,
    points: Floats,
    count: int,
    progress: Floats,
    plan_interval: float,
    tail_speed: float,
    speed: float,
    ego_length: float,
    ego_width: float,
    poses: Floats,
    length: float,
    width: float,
    own: Floats,
    their: Floats,
    column: int,
    deceleration: float,
) -> None:
    """Least gap between the outlines over the horizon, as a share of NEAR, and its time as a share of HORIZON."""
    least, when = NEAR, HORIZON
    radii = 0.5 * (math.hypot(ego_length, ego_width) + math.hypot(length, width))
    for step in range(STEPS + 1):
        time = step * INTERVAL
        position = ego_position(progress, plan_interval, tail_speed, speed, deceleration, time)
        x, y, yaw = pose_on(points, count, position)
        dx, dy = poses[step, 0] - x, poses[step, 1] - y
        if math.hypot(dx, dy) - radii >= least:
            continue
        fill_corners(own, x, y, yaw, ego_length, ego_width)
        fill_corners(their, poses[step, 0], poses[step, 1], poses[step, 2], length, width)
        gap = corner_distance(own, their)
        if gap < least:
            least, when = gap, time
            if gap <= 0.0:
                break
    row[column], row[column + 1] = least / NEAR, when / HORIZON


@compiled
def fill_participants(
    tokens: Tokens,
    rows: NDArray[np.int32],
    reach: float,
    points: Floats,
    count: int,
    zero: int,
    progress: Floats,
    plan_interval: float,
    tail_speed: float,
    speed: float,
    ego_length: float,
    ego_width: float,
    kind: NDArray[np.uint8],
    x: Floats,
    y: Floats,
    yaw: Floats,
    other_speed: Floats,
    acceleration: Floats,
    yaw_rate: Floats,
    length: Floats,
    width: Floats,
) -> int:
    """Write one token for every object within ``reach`` [m]; returns their number."""
    own = np.empty((4, 2), dtype=np.float64)
    their = np.empty((4, 2), dtype=np.float64)
    poses = np.empty((STEPS + 1, 4), dtype=np.float64)
    ego_x, ego_y, ego_yaw = points[0, zero], points[1, zero], points[3, zero]
    cosine, sine = math.cos(ego_yaw), math.sin(ego_yaw)
    number = 0
    for index in range(x.shape[0]):
        dx, dy = x[index] - ego_x, y[index] - ego_y
        far = math.hypot(dx, dy)
        if far > reach:
            continue
        row = tokens[number]
        row[:] = 0.0
        rows[number] = index
        number += 1
        turned = wrap_angle(yaw[index] - ego_yaw)
        row[PARTICIPANT] = 1.0
        row[X], row[Y] = (dx * cosine + dy * sine) / 40.0, (dy * cosine - dx * sine) / 20.0
        row[COS], row[SIN] = math.cos(turned), math.sin(turned)
        row[LENGTH], row[WIDTH] = length[index] / 10.0, width[index] / 3.0
        row[VELOCITY_X] = (other_speed[index] * math.cos(turned) - speed) / 10.0
        row[VELOCITY_Y] = other_speed[index] * math.sin(turned) / 10.0
        row[SPEED], row[YAW_RATE] = other_speed[index] / 15.0, max(-2.0, min(2.0, yaw_rate[index]))
        row[ACCELERATION] = max(-8.0, min(8.0, acceleration[index])) / 4.0
        row[VULNERABLE] = 1.0 if kind[index] >= 5 else 0.0
        s, d, off = coordinates_on(points, count, x[index], y[index], yaw[index])
        row[ALONG], row[ASIDE] = max(-2.0, min(2.0, s / 40.0)), max(-3.0, min(3.0, d / 10.0))
        row[TURNED_COS], row[TURNED_SIN] = math.cos(off), math.sin(off)
        if s < -0.5 * (ego_length + length[index]) and abs(d) < 0.5 * (ego_width + width[index]) and abs(off) < 1.0:
            row[BEHIND] = 1.0
        fill_corners(own, ego_x, ego_y, ego_yaw, ego_length, ego_width)
        fill_corners(their, x[index], y[index], yaw[index], length[index], width[index])
        row[GAP] = min(20.0, corner_distance(own, their)) / 20.0

        poses[0, 0], poses[0, 1], poses[0, 2], poses[0, 3] = x[index], y[index], yaw[index], other_speed[index]
        roll_object(poses, 0, STEPS, yaw_rate[index], 0.0, INTERVAL)
        _forecast(
            row,
            points,
            count,
            progress,
            plan_interval,
            tail_speed,
            speed,
            ego_length,
            ego_width,
            poses,
            length[index],
            width[index],
            own,
            their,
            FORECAST,
            -1.0,
        )
        _forecast(
            row,
            points,
            count,
            progress,
            plan_interval,
            tail_speed,
            speed,
            ego_length,
            ego_width,
            poses,
            length[index],
            width[index],
            own,
            their,
            FORECAST + 4,
            3.2,
        )
        _forecast(
            row,
            points,
            count,
            progress,
            plan_interval,
            tail_speed,
            speed,
            ego_length,
            ego_width,
            poses,
            length[index],
            width[index],
            own,
            their,
            FORECAST + 6,
            8.0,
        )
        poses[0, 3] = max(other_speed[index], 0.05) if acceleration[index] > 0.0 else other_speed[index]
        roll_object(poses, 0, STEPS, yaw_rate[index], max(-6.0, min(2.5, acceleration[index])), INTERVAL)
        _forecast(
            row,
            points,
            count,
            progress,
            plan_interval,
            tail_speed,
            speed,
            ego_length,
            ego_width,
            poses,
            length[index],
            width[index],
            own,
            their,
            FORECAST + 2,
            -1.0,
        )

        row[ENTER], row[THEY_ENTER], row[THEY_LEAVE] = 1.0, 1.0, 1.0
        half_swath = 0.5 * (ego_width + width[index])
        begin, _end, least, greatest, _ = shared_ground(
            points,
            count,
            zero,
            half_swath,
            x[index],
            y[index],
            yaw[index],
            other_speed[index],
            yaw_rate[index],
            0.5 * length[index],
            80.0,
        )
        if begin < math.inf:
            pace = max(other_speed[index], 0.3)
            enter = planned_time(progress, plan_interval, tail_speed, begin - 0.5 * (ego_length + width[index]))
            row[ENTER] = min(enter, CONFLICT) / CONFLICT
            row[THEY_ENTER] = min(max(0.0, least - 0.5 * length[index] - 0.5 * ego_width) / pace, CONFLICT) / CONFLICT
            row[THEY_LEAVE] = (
                min(max(0.0, greatest + 0.5 * length[index] + 0.5 * ego_width) / pace, CONFLICT) / CONFLICT
            )
    return number


@compiled
def fill_plan(
    tokens: Tokens,
    first: int,
    points: Floats,
    count: int,
    zero: int,
    progress: Floats,
    plan_interval: float,
    tail_speed: float,
) -> None:
    """Write PLAN_TOKENS tokens of the planned trajectory, in equal steps of time."""
    ego_x, ego_y, ego_yaw = points[0, zero], points[1, zero], points[3, zero]
    cosine, sine = math.cos(ego_yaw), math.sin(ego_yaw)
    before = 0.0
    for index in range(PLAN_TOKENS):
        time = (index + 1) * PLAN_INTERVAL
        position = planned_position(progress, plan_interval, tail_speed, time)
        x, y, yaw = pose_on(points, count, position)
        row = tokens[first + index]
        row[:] = 0.0
        row[POINT] = 1.0
        dx, dy = x - ego_x, y - ego_y
        row[X], row[Y] = (dx * cosine + dy * sine) / 40.0, (dy * cosine - dx * sine) / 20.0
        row[COS], row[SIN] = math.cos(yaw - ego_yaw), math.sin(yaw - ego_yaw)
        row[SPEED] = (position - before) / PLAN_INTERVAL / 15.0
        row[ALONG] = time / HORIZON
        before = position


@compiled
def fill_ego(
    row: Tokens,
    speed: float,
    yaw_rate: float,
    length: float,
    width: float,
    action: float,
    acceleration: float,
    stood: float,
    changes: float,
    zones: Floats,
    stage: int,
    positions: Floats,
    signals: NDArray[np.uint8],
) -> None:
    """Write the ego's token; ``zones`` has the rows stage, begin, end, rule, signal of the route's zones."""
    row[:] = 0.0
    row[EGO] = 1.0
    row[LENGTH], row[WIDTH], row[SPEED], row[YAW_RATE] = (
        length / 10.0,
        width / 3.0,
        speed / 15.0,
        max(-2.0, min(2.0, yaw_rate)),
    )
    row[ACTION], row[STOOD] = action, min(stood, 10.0) / 10.0
    row[EGO_ACCELERATION] = max(-10.0, min(10.0, acceleration)) / 4.0
    row[STAGE_CHANGE] = changes
    row[ZONE_BEGIN], row[ZONE_END] = 1.0, 1.0
    nearest = math.inf
    for index in range(zones.shape[0]):
        if int(zones[index, 0]) != stage:
            continue
        begin = zones[index, 1] - positions[stage] - 0.5 * length
        end = zones[index, 2] - positions[stage] + 0.5 * length
        if end <= 0.0 or begin >= nearest:
            continue
        nearest = begin
        row[ZONE_BEGIN] = max(-20.0, min(begin, ZONE_REACH)) / ZONE_REACH
        row[ZONE_END] = min(end, ZONE_REACH) / ZONE_REACH
        row[ZONE_INSIDE] = 1.0 if begin < 0.0 else 0.0
        row[ZONE_RULE : ZONE_RULE + 5] = 0.0
        row[ZONE_RULE + int(zones[index, 3])] = 1.0
        light = int(zones[index, 4])
        halt = 0 <= light < signals.shape[0] and (signals[light] == 1 or signals[light] == 2)
        row[ZONE_HALT] = 1.0 if halt else 0.0
