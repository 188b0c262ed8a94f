"""The way ahead of the ego: an evenly sampled line with the lane change in it, and who will stand on it when."""

import math

import numpy as np
from numpy.typing import NDArray

from roadmend.core.geometry import wrap_angle
from roadmend.core.jit import compiled
from roadmend.policies import prediction, road

Floats = NDArray[np.float64]
Record = NDArray[np.void]

POINTS = 100
BEHIND = 3.0  # [m] of the path behind the ego's centre
_AHEAD_MIN = 70.0  # [m]
_AHEAD_TIME = 6.0  # [s] of driving that the path covers

# Columns of a path; row i lies at (i * spacing - BEHIND) metres ahead of the ego's centre.
X, Y, COS, SIN, HALF, SPEED = range(6)  # [m], [m], heading, heading, half width swept [m], allowed speed [m/s]

# Columns of the table of occupancies
LOW, HIGH = range(2)  # [m] ahead of the ego's centre; inf, -inf where the object is not on the path


@compiled
def blend(u: float) -> float:
    """Weight of the new lane after a share u in 0..1 of a lane change (quintic: smooth in slope and curvature)."""
    inside = min(max(u, 0.0), 1.0)
    return inside * inside * inside * (10.0 + inside * (-15.0 + 6.0 * inside))


@compiled
def path_spacing(speed: float) -> float:
    """Distance between the points of the path [m] at a speed of the ego [m/s]."""
    return (max(_AHEAD_MIN, _AHEAD_TIME * speed + 20.0) + BEHIND) / (POINTS - 1)


@compiled
def build_path(
    samples: Floats, stages: Floats, parameters: Record, memory: Record, speed: float, length: float, width: float
) -> Floats:
    """The path from just behind the ego on, shape (POINTS, 6); lateral errors fade out along it.

    ``length`` and ``width`` are the ego's [m]. The swept half width grows in curves because the ego's corners swing
    out.
    """
    p, m = parameters[0], memory[0]
    out = np.empty((POINTS, 6), dtype=np.float64)
    spacing = path_spacing(speed)
    stage = int(m.stage)
    first, count = int(stages[stage, road.FIRST]), int(stages[stage, road.COUNT])
    changing = m.changing > 0.0
    has_next = stage + 1 < stages.shape[0]
    next_first, next_count = 0, 2
    if has_next:
        next_first, next_count = int(stages[stage + 1, road.FIRST]), int(stages[stage + 1, road.COUNT])
    swing = 0.125 * length * length
    fade = max(p.change_length_min, p.change_time * speed) * 0.5
    for index in range(POINTS):
        ahead = index * spacing - BEHIND
        x, y, yaw, curvature, allowed = road.pose_on(samples, first, count, m.s + ahead)
        if has_next and (changing or m.s + ahead > stages[stage, road.WINDOW_BEGIN]):
            to_x, to_y, to_yaw, to_curvature, to_allowed = road.pose_on(
                samples, next_first, next_count, m.s_next + ahead
            )
            allowed = min(allowed, to_allowed)
            if changing:
                u = m.progress + ahead / m.change_length
                weight = blend(u)
                side_x, side_y = to_x - x, to_y - y
                inside = min(max(u, 0.0), 1.0)
                slope = 30.0 * inside * inside * (1.0 - inside) * (1.0 - inside) / m.change_length
                across = math.cos(yaw) * side_y - math.sin(yaw) * side_x
                x += weight * side_x
                y += weight * side_y
                yaw += weight * wrap_angle(to_yaw - yaw) + math.atan(slope * across)
                curvature += weight * (to_curvature - curvature)
        cosine, sine = math.cos(yaw), math.sin(yaw)
        if not changing and m.offset != 0.0:
            left = m.offset * (1.0 - blend(ahead / fade))
            x -= left * sine
            y += left * cosine
        out[index, X], out[index, Y], out[index, COS], out[index, SIN] = x, y, cosine, sine
        out[index, HALF] = 0.5 * width + swing * abs(curvature)
        out[index, SPEED] = allowed
    return out


@compiled
def speed_on(path: Floats, spacing: float, ahead: float) -> float:
    """Speed allowed [m/s] at a distance ahead of the ego's centre [m]."""
    place = min(max((ahead + BEHIND) / spacing, 0.0), POINTS - 1.001)
    index = int(place)
    return float(path[index, SPEED] + (place - index) * (path[index + 1, SPEED] - path[index, SPEED]))


@compiled
def pose_ahead(path: Floats, spacing: float, ahead: float) -> tuple[float, float, float]:
    """x, y [m] and heading [rad] at a distance ahead of the ego's centre [m]."""
    place = max((ahead + BEHIND) / spacing, 0.0)
    index = min(int(place), POINTS - 2)
    share = place - index
    x = path[index, X] + share * (path[index + 1, X] - path[index, X])
    y = path[index, Y] + share * (path[index + 1, Y] - path[index, Y])
    cosine = path[index, COS] + share * (path[index + 1, COS] - path[index, COS])
    sine = path[index, SIN] + share * (path[index + 1, SIN] - path[index, SIN])
    return x, y, math.atan2(sine, cosine)


@compiled
def standing_on(
    path: Floats, spacing: float, x: float, y: float, cosine: float, sine: float,
    half_length: float, half_width: float, sweep: float, margin: float,
) -> tuple[float, float, float]:  # fmt: skip
    """Stretch of the path [m ahead] that a rectangle covers, and the cosine between its heading and the path's there.

    ``sweep`` [m] lengthens rectangles that cross the path on both ends, so that samples in time leave no holes.
    Returns inf, -inf and 0 where the rectangle keeps clear.
    """
    low, high, along_path = math.inf, -math.inf, 0.0
    reach = math.hypot(half_length + sweep + 1.3 + margin, half_width + 1.3 + margin)
    near = (reach + spacing) * (reach + spacing)
    index = 0
    while index < POINTS:
        dx, dy = path[index, X] - x, path[index, Y] - y
        square = dx * dx + dy * dy
        if square > near:
            if high > low:
                break
            index += max(1, int((math.sqrt(square) - reach) / spacing))
            continue
        parallel = path[index, COS] * cosine + path[index, SIN] * sine
        crossing = abs(path[index, COS] * sine - path[index, SIN] * cosine)
        half = path[index, HALF] + margin
        extent = half_length + half * crossing + (sweep if crossing > 0.5 else 0.0)
        if abs(dx * cosine + dy * sine) < extent and abs(dy * cosine - dx * sine) < half_width + half * abs(parallel):
            ahead = index * spacing - BEHIND
            if high < low:
                low, along_path = ahead - 0.5 * spacing, parallel
            high = ahead + 0.5 * spacing
        elif high > low:
            break
        index += 1
    return low, high, along_path


@compiled
def may_meet(
    path: Floats, spacing: float, forecast: Floats, half_length: float, half_width: float, margin: float
) -> bool:
    """Whether a forecast comes near the path at all: one coarse look before the fine one."""
    last = prediction.TIMES - 1
    x = 0.5 * (forecast[0, prediction.FX] + forecast[last, prediction.FX])
    y = 0.5 * (forecast[0, prediction.FY] + forecast[last, prediction.FY])
    reach = 0.5 * forecast[last, prediction.FWAY] + half_length + half_width + 1.5 + margin
    index = 0
    while index < POINTS:
        away = math.hypot(path[index, X] - x, path[index, Y] - y)
        if away <= reach:
            return True
        index += max(1, int((away - reach) / spacing))
    return False


@compiled
def occupy(
    path: Floats, spacing: float, row: Floats, forecast: Floats, margin: float, out: Floats
) -> tuple[int, float]:
    """Fill ``out`` (TIMES, 2) with the stretch that an object covers at each time.

    Returns the first time index at which it is on the path (-1: never) and the cosine between headings there.
    """
    begin, parallel = -1, 0.0
    for index in range(prediction.TIMES):
        interval = prediction.FINE_INTERVAL if index <= prediction.FINE else prediction.COARSE_INTERVAL
        sweep = 0.5 * forecast[index, prediction.FSPEED] * interval if index > 0 else 0.0
        low, high, along_path = standing_on(
            path, spacing,
            forecast[index, prediction.FX], forecast[index, prediction.FY],
            forecast[index, prediction.FCOS], forecast[index, prediction.FSIN],
            row[prediction.HALF_LENGTH], row[prediction.HALF_WIDTH], sweep, margin,
        )  # fmt: skip
        out[index, LOW], out[index, HIGH] = low, high
        if begin < 0 and high > low:
            begin, parallel = index, along_path
    return begin, parallel
