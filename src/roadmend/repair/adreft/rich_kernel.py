"""Fills the rich tokens of one tick: see ``rich_tokens`` for what they mean."""

import math

import numpy as np
from numpy.typing import NDArray

from roadmend.core.geometry import Outline, corner_distance, fill_corners, fill_outline, wrap_angle
from roadmend.core.jit import compiled
from roadmend.core.scene import EgoState, Objects
from roadmend.repair.conflict import shared_ground
from roadmend.repair.contact import braked_position, roll_object
from roadmend.repair.planned_path import (
    PlannedPath,
    coordinates_on,
    planned_position,
    planned_time,
    pose_at,
    pose_on,
    position_at,
)

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
    column: int,
    path: PlannedPath,
    ego: EgoState,
    other: Outline,
    poses: Floats,
    corners: Floats,
    deceleration: float,
) -> None:
    """Least gap between the outlines over the horizon, as a share of NEAR, and its time as a share of HORIZON.

    ``poses`` are the object's; ``corners`` (2 x 4 x 2) is scratch.
    """
    own, their = corners[0], corners[1]
    speed = max(0.0, ego.speed)
    points, progress, interval, tail_speed = path.points, path.progress, path.interval, path.tail_speed
    least, when = NEAR, HORIZON
    radii = 0.5 * (math.hypot(ego.length, ego.width) + math.hypot(other.length, other.width))
    for step in range(STEPS + 1):
        time = step * INTERVAL
        position = braked_position(position_at(progress, interval, tail_speed, time), speed, deceleration, time)
        x, y, yaw = pose_at(points, path.size, position)
        dx, dy = poses[step, 0] - x, poses[step, 1] - y
        if math.hypot(dx, dy) - radii >= least:
            continue
        fill_corners(own, x, y, yaw, ego.length, ego.width)
        fill_corners(their, poses[step, 0], poses[step, 1], poses[step, 2], other.length, other.width)
        gap = corner_distance(own, their)
        if gap < least:
            least, when = gap, time
            if gap <= 0.0:
                break
    row[column], row[column + 1] = least / NEAR, when / HORIZON


@compiled
def fill_participants(
    tokens: Tokens, rows: NDArray[np.int32], reach: float, path: PlannedPath, ego: EgoState, objects: Objects
) -> int:
    """Write one token for every object within ``reach`` [m]; returns their number."""
    path, ego = PlannedPath(*path), EgoState(*ego)
    speed = max(0.0, ego.speed)
    corners = np.empty((2, 4, 2), dtype=np.float64)
    poses = np.empty((STEPS + 1, 4), dtype=np.float64)
    cosine, sine = math.cos(ego.yaw), math.sin(ego.yaw)
    number = 0
    for index in range(objects.shape[0]):
        other = objects[index]
        dx, dy = other.x - ego.x, other.y - ego.y
        far = math.hypot(dx, dy)
        if far > reach:
            continue
        row = tokens[number]
        row[:] = 0.0
        rows[number] = index
        number += 1
        turned = wrap_angle(other.yaw - ego.yaw)
        row[PARTICIPANT] = 1.0
        row[X], row[Y] = (dx * cosine + dy * sine) / 40.0, (dy * cosine - dx * sine) / 20.0
        row[COS], row[SIN] = math.cos(turned), math.sin(turned)
        row[LENGTH], row[WIDTH] = other.length / 10.0, other.width / 3.0
        row[VELOCITY_X] = (other.speed * math.cos(turned) - speed) / 10.0
        row[VELOCITY_Y] = other.speed * math.sin(turned) / 10.0
        row[SPEED], row[YAW_RATE] = other.speed / 15.0, max(-2.0, min(2.0, other.yaw_rate))
        row[ACCELERATION] = max(-8.0, min(8.0, other.acceleration)) / 4.0
        row[VULNERABLE] = 1.0 if other.kind >= 5 else 0.0
        s, d, off = coordinates_on(path, other.x, other.y, other.yaw)
        row[ALONG], row[ASIDE] = max(-2.0, min(2.0, s / 40.0)), max(-3.0, min(3.0, d / 10.0))
        row[TURNED_COS], row[TURNED_SIN] = math.cos(off), math.sin(off)
        if s < -0.5 * (ego.length + other.length) and abs(d) < 0.5 * (ego.width + other.width) and abs(off) < 1.0:
            row[BEHIND] = 1.0
        fill_outline(corners[0], ego)
        fill_outline(corners[1], other)
        row[GAP] = min(20.0, corner_distance(corners[0], corners[1])) / 20.0

        poses[0, 0], poses[0, 1], poses[0, 2], poses[0, 3] = other.x, other.y, other.yaw, other.speed
        roll_object(poses, 0, STEPS, other.yaw_rate, 0.0, INTERVAL)
        _forecast(row, FORECAST, path, ego, other, poses, corners, -1.0)
        _forecast(row, FORECAST + 4, path, ego, other, poses, corners, 3.2)
        _forecast(row, FORECAST + 6, path, ego, other, poses, corners, 8.0)
        poses[0, 3] = max(other.speed, 0.05) if other.acceleration > 0.0 else other.speed
        roll_object(poses, 0, STEPS, other.yaw_rate, max(-6.0, min(2.5, other.acceleration)), INTERVAL)
        _forecast(row, FORECAST + 2, path, ego, other, poses, corners, -1.0)

        row[ENTER], row[THEY_ENTER], row[THEY_LEAVE] = 1.0, 1.0, 1.0
        ground = shared_ground(path, other, 0.5 * (ego.width + other.width), 0.5 * other.length, 80.0)
        if ground.begin < math.inf:
            pace = max(other.speed, 0.3)
            enter = planned_time(path, ground.begin - 0.5 * (ego.length + other.width))
            they_enter = max(0.0, ground.least - 0.5 * other.length - 0.5 * ego.width) / pace
            they_leave = max(0.0, ground.greatest + 0.5 * other.length + 0.5 * ego.width) / pace
            row[ENTER] = min(enter, CONFLICT) / CONFLICT
            row[THEY_ENTER] = min(they_enter, CONFLICT) / CONFLICT
            row[THEY_LEAVE] = min(they_leave, CONFLICT) / CONFLICT
    return number


@compiled
def fill_plan(tokens: Tokens, path: PlannedPath) -> None:
    """Write PLAN_TOKENS tokens of the planned trajectory, in equal steps of time."""
    path = PlannedPath(*path)
    ego_x, ego_y, ego_yaw = path.points[0, path.zero], path.points[1, path.zero], path.points[3, path.zero]
    cosine, sine = math.cos(ego_yaw), math.sin(ego_yaw)
    before = 0.0
    for index in range(PLAN_TOKENS):
        time = (index + 1) * PLAN_INTERVAL
        position = planned_position(path, time)
        x, y, yaw = pose_on(path, position)
        row = tokens[index]
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
    ego: EgoState,
    path: PlannedPath,
    action: float,
    acceleration: float,
    stood: float,
    zones: Floats,
    signals: NDArray[np.uint8],
) -> None:
    """Write the ego's token; ``zones`` has the rows stage, begin, end, rule, signal of the route's zones."""
    ego, path = EgoState(*ego), PlannedPath(*path)
    speed = max(0.0, ego.speed)
    stage, position = path.stage, path.stage_positions[path.stage]
    row[:] = 0.0
    row[EGO] = 1.0
    row[LENGTH], row[WIDTH], row[SPEED], row[YAW_RATE] = (
        ego.length / 10.0,
        ego.width / 3.0,
        speed / 15.0,
        max(-2.0, min(2.0, ego.yaw_rate)),
    )
    row[ACTION], row[STOOD] = action, min(stood, 10.0) / 10.0
    row[EGO_ACCELERATION] = max(-10.0, min(10.0, acceleration)) / 4.0
    row[STAGE_CHANGE] = path.stage_positions.shape[0] - 1 - stage
    row[ZONE_BEGIN], row[ZONE_END] = 1.0, 1.0
    nearest = math.inf
    for index in range(zones.shape[0]):
        if int(zones[index, 0]) != stage:
            continue
        begin = zones[index, 1] - position - 0.5 * ego.length
        end = zones[index, 2] - position + 0.5 * ego.length
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
