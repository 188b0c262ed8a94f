"""The path ahead of the ego: an evenly sampled line with the lane change in it."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from roadmend.core.jit import compiled
from roadmend.core.scene import EgoState
from roadmend.policies import road
from roadmend.policies.road import RouteTables

Floats = NDArray[np.float64]
Record = NDArray[np.void]

POINTS = 100
BEHIND = 3.0  # [m] of the path behind the ego's centre
_AHEAD_MIN = 70.0  # [m]
_AHEAD_TIME = 6.0  # [s] of driving that the path covers

# Columns of a path; row i lies at (i * spacing - BEHIND) metres ahead of the ego's centre.
# Place [m], heading, half width swept [m], allowed speed [m/s], curvature [1/m].
X, Y, COS, SIN, HALF, SPEED, BEND = range(7)


class PathAhead(NamedTuple):
    """One tick's path."""

    points: Floats  # (POINTS, 7), see the columns above
    spacing: float  # [m] between two points


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
def build_path(route: RouteTables, parameters: Record, memory: Record, ego: EgoState) -> PathAhead:
    """The path from just behind the ego on; lateral errors fade out along it.

    The swept half width grows in curves because the ego's corners swing out.
    """
    p, m, samples, stages = parameters[0], memory[0], route.samples, route.stages
    out = np.empty((POINTS, 7), dtype=np.float64)
    spacing = path_spacing(ego.speed)
    stage = int(m.stage)
    first, count = int(stages[stage, road.FIRST]), int(stages[stage, road.COUNT])
    changing = m.changing > 0.0
    has_next = stage + 1 < stages.shape[0]
    next_first, next_count = 0, 2
    if has_next:
        next_first, next_count = int(stages[stage + 1, road.FIRST]), int(stages[stage + 1, road.COUNT])
    swing = 0.125 * ego.length * ego.length
    fade = max(p.change_length_min, p.change_time * ego.speed) * 0.5
    for index in range(POINTS):
        ahead = index * spacing - BEHIND
        x, y, cosine, sine, curvature, allowed = road.pose_on(samples, first, count, m.s + ahead)
        if has_next and (changing or m.s + ahead > stages[stage, road.WINDOW_BEGIN]):
            to_x, to_y, to_cosine, to_sine, to_curvature, to_allowed = road.pose_on(
                samples, next_first, next_count, m.s_next + ahead
            )
            allowed = min(allowed, to_allowed)
            if changing:
                u = min(max(m.progress + ahead / m.change_length, 0.0), 1.0)
                weight = blend(u)
                side_x, side_y = to_x - x, to_y - y
                slope = 30.0 * u * u * (1.0 - u) * (1.0 - u) / m.change_length
                rise = slope * (cosine * side_y - sine * side_x)
                x += weight * side_x
                y += weight * side_y
                along_x = cosine + weight * (to_cosine - cosine)
                along_y = sine + weight * (to_sine - sine)
                cosine, sine = along_x - rise * along_y, along_y + rise * along_x
                scale = 1.0 / math.sqrt(cosine * cosine + sine * sine)
                cosine, sine = cosine * scale, sine * scale
                curvature += weight * (to_curvature - curvature)
        if not changing and m.offset != 0.0:
            left = m.offset * (1.0 - blend(ahead / fade))
            x -= left * sine
            y += left * cosine
        out[index, X], out[index, Y], out[index, COS], out[index, SIN] = x, y, cosine, sine
        out[index, HALF] = 0.5 * ego.width + swing * abs(curvature)
        out[index, SPEED] = allowed
        out[index, BEND] = abs(curvature)
    return PathAhead(out, spacing)


@compiled
def speed_on(path: PathAhead, ahead: float) -> float:
    """Speed allowed [m/s] at a distance ahead of the ego's centre [m]."""
    points = path.points
    place = min(max((ahead + BEHIND) / path.spacing, 0.0), POINTS - 1.001)
    index = int(place)
    return float(points[index, SPEED] + (place - index) * (points[index + 1, SPEED] - points[index, SPEED]))


@compiled
def pose_ahead(path: PathAhead, ahead: float) -> tuple[float, float, float]:
    """x, y [m] and heading [rad] at a distance ahead of the ego's centre [m]."""
    points = path.points
    place = max((ahead + BEHIND) / path.spacing, 0.0)
    index = min(int(place), POINTS - 2)
    share = place - index
    x = points[index, X] + share * (points[index + 1, X] - points[index, X])
    y = points[index, Y] + share * (points[index + 1, Y] - points[index, Y])
    cosine = points[index, COS] + share * (points[index + 1, COS] - points[index, COS])
    sine = points[index, SIN] + share * (points[index + 1, SIN] - points[index, SIN])
    return x, y, math.atan2(sine, cosine)
