"""The way ahead of the ego: an evenly sampled line with the lane change in it, and who will stand on it when."""

import math

import numpy as np
from numpy.typing import NDArray

from roadmend.core.jit import compiled
from roadmend.policies import prediction, road

Floats = NDArray[np.float64]
Record = NDArray[np.void]

POINTS = 100
BEHIND = 3.0  # [m] of the path behind the ego's centre
_AHEAD_MIN = 70.0  # [m]
_LOOK_AROUND = 9  # every so many points in time the whole path is searched for the place nearest to an object
SAME_WAY = 0.5  # cosine between headings from which two go the same way
_SLACK = 0.3  # [m] by which a look at the nearest place alone may be wrong
_AHEAD_TIME = 6.0  # [s] of driving that the path covers

# Columns of a path; row i lies at (i * spacing - BEHIND) metres ahead of the ego's centre.
# Place [m], heading, half width swept [m], allowed speed [m/s], curvature [1/m].
X, Y, COS, SIN, HALF, SPEED, BEND = range(7)

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
    """The path from just behind the ego on, shape (POINTS, 7); lateral errors fade out along it.

    ``length`` and ``width`` are the ego's [m]. The swept half width grows in curves because the ego's corners swing
    out.
    """
    p, m = parameters[0], memory[0]
    out = np.empty((POINTS, 7), dtype=np.float64)
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
        out[index, HALF] = 0.5 * width + swing * abs(curvature)
        out[index, SPEED] = allowed
        out[index, BEND] = abs(curvature)
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
def _nearest(path: Floats, spacing: float, x: float, y: float, hint: int, everywhere: bool) -> tuple[int, float]:  # noqa: FBT001
    """Index of the point of the path nearest to a place [m], and the distance [m].

    Walks downhill from ``hint``; with ``everywhere`` the whole path is looked at as well, in leaps over what must be
    further away.
    """
    best = hint
    dx, dy = path[best, X] - x, path[best, Y] - y
    least = dx * dx + dy * dy
    for step in (1, -1):
        index = best + step
        while 0 <= index < POINTS:
            dx, dy = path[index, X] - x, path[index, Y] - y
            square = dx * dx + dy * dy
            if square >= least:
                break
            best, least = index, square
            index += step
    distance = math.sqrt(least)
    if everywhere:
        index = 0
        while index < POINTS:
            dx, dy = path[index, X] - x, path[index, Y] - y
            away = math.sqrt(dx * dx + dy * dy)
            if away < distance:
                best, distance = index, away
            index += max(1, int((away - distance) / spacing))
    return best, distance


@compiled
def _is_covered(
    path: Floats,
    index: int,
    x: float,
    y: float,
    cosine: float,
    sine: float,
    half_length: float,
    half_width: float,
    sweep: float,
    margin: float,
) -> bool:
    """Whether the ego's width at a point of the path meets a rectangle, lengthened by ``sweep`` if it crosses."""
    dx, dy = path[index, X] - x, path[index, Y] - y
    parallel = abs(path[index, COS] * cosine + path[index, SIN] * sine)
    crossing = abs(path[index, COS] * sine - path[index, SIN] * cosine)
    half = path[index, HALF] + margin
    extent = half_length + half * crossing + (sweep if crossing > 0.5 else 0.0)
    if abs(dx * cosine + dy * sine) >= extent:
        return False
    return bool(abs(dy * cosine - dx * sine) < half_width + half * parallel)


@compiled
def _cover(
    path: Floats,
    spacing: float,
    place: int,
    x: float,
    y: float,
    cosine: float,
    sine: float,
    half_length: float,
    half_width: float,
    sweep: float,
    margin: float,
) -> tuple[float, float, float]:
    """Stretch of the path [m ahead] around point ``place`` that a rectangle covers, and the cosine of the headings.

    ``sweep`` [m] lengthens rectangles that cross the path at both ends, so that samples in time leave no holes.
    Returns inf, -inf and 0 where the rectangle keeps clear.
    """
    shape = (x, y, cosine, sine, half_length, half_width, sweep, margin)
    first = place
    if not _is_covered(path, place, *shape):
        # Not where it is nearest: perhaps with a corner, where the path bends.
        around = int((half_length + sweep + half_width + 2.0 + margin) / spacing) + 1
        first, end = max(0, place - around), min(POINTS, place + around + 1)
        while first < end and not _is_covered(path, first, *shape):
            first += 1
        if first == end:
            return math.inf, -math.inf, 0.0
    last = first
    while first > 0 and _is_covered(path, first - 1, *shape):
        first -= 1
    while last + 1 < POINTS and _is_covered(path, last + 1, *shape):
        last += 1
    parallel = path[first, COS] * cosine + path[first, SIN] * sine
    return (first - 0.5) * spacing - BEHIND, (last + 0.5) * spacing - BEHIND, parallel


@compiled
def occupy(
    path: Floats, spacing: float, row: Floats, forecast: Floats, margin: float, last: int, out: Floats
) -> tuple[int, float]:
    """Fill ``out`` (TIMES, 2) with the stretch that an object covers at each time up to index ``last``.

    Whoever is on the path from the beginning and goes its way is not followed further: its gap says more.
    Returns the first time index at which it is on the path (-1: never) and the cosine between headings there.
    """
    begin, parallel = -1, 0.0
    half_length, half_width = row[prediction.HALF_LENGTH], row[prediction.HALF_WIDTH]
    fastest = max(forecast[0, prediction.FSPEED], forecast[prediction.TIMES - 1, prediction.FSPEED])
    longest = half_length + 0.5 * fastest * prediction.COARSE_INTERVAL
    reach = math.hypot(longest + 1.3 + margin, half_width + 1.3 + margin)
    place, looked, clear = 0, 0.0, 0.0  # way of the object at the last look [m], how far it may move from there [m]
    for index in range(prediction.TIMES):
        driven = forecast[index, prediction.FWAY]
        out[index, LOW], out[index, HIGH] = math.inf, -math.inf
        if index > last or driven - looked < clear:
            continue
        if index > 1 and driven == looked:
            out[index] = out[index - 1]  # it stands
            continue
        x, y = forecast[index, prediction.FX], forecast[index, prediction.FY]
        cosine, sine = forecast[index, prediction.FCOS], forecast[index, prediction.FSIN]
        place, distance = _nearest(path, spacing, x, y, place, clear > 0.0 or index % _LOOK_AROUND == 0)
        looked, clear = driven, distance - reach
        if clear > 0.0:
            continue
        interval = prediction.FINE_INTERVAL if index <= prediction.FINE else prediction.COARSE_INTERVAL
        sweep = 0.5 * forecast[index, prediction.FSPEED] * interval if index > 0 else 0.0
        # Beside the path: the rectangle's extent across it, and how far the path bends within the rectangle's length.
        along = abs(path[place, COS] * cosine + path[place, SIN] * sine)
        across = abs(path[place, COS] * sine - path[place, SIN] * cosine)
        extent = half_width * along + (half_length + sweep) * across + path[place, HALF] + margin
        if distance > extent + _SLACK + 0.5 * path[place, BEND] * (half_length + 2.0) * (half_length + 2.0):
            continue
        low, high, along_path = _cover(path, spacing, place, x, y, cosine, sine, half_length, half_width, sweep, margin)
        out[index, LOW], out[index, HIGH] = low, high
        if begin < 0 and high > low:
            begin, parallel = index, along_path
            if begin == 0 and parallel > SAME_WAY:
                last = 0
    return begin, parallel
