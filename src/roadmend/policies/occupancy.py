"""Who will stand on the path ahead when: the stretch of it that each object covers at each time."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from roadmend.core.jit import compiled
from roadmend.policies import prediction
from roadmend.policies.path_ahead import BEHIND, BEND, COS, HALF, POINTS, SIN, PathAhead, X, Y

Floats = NDArray[np.float64]

# Columns of the table of occupancies
LOW, HIGH = range(2)  # [m] ahead of the ego's centre; inf, -inf where the object is not on the path

SAME_WAY = 0.5  # cosine between headings from which two go the same way
_LOOK_AROUND = 9  # every so many points in time the whole path is searched for the place nearest to an object
_SLACK = 0.3  # [m] by which a look at the nearest place alone may be wrong


class _Rectangle(NamedTuple):
    """An object's outline at one time, and how it counts."""

    x: float  # [m]
    y: float  # [m]
    cosine: float
    sine: float
    half_length: float  # [m]
    half_width: float  # [m]
    sweep: float  # [m] lengthens it at both ends where it crosses the path, so that samples in time leave no holes
    margin: float  # [m] kept from it


@compiled
def _nearest(path: PathAhead, x: float, y: float, hint: int, everywhere: bool) -> tuple[int, float]:  # noqa: FBT001
    """Index of the point of the path nearest to a place [m], and the distance [m].

    Walks downhill from ``hint``; with ``everywhere`` the whole path is looked at as well, in leaps over what must be
    further away.
    """
    points, spacing = path.points, path.spacing
    best = hint
    dx, dy = points[best, X] - x, points[best, Y] - y
    least = dx * dx + dy * dy
    for step in (1, -1):
        index = best + step
        while 0 <= index < POINTS:
            dx, dy = points[index, X] - x, points[index, Y] - y
            square = dx * dx + dy * dy
            if square >= least:
                break
            best, least = index, square
            index += step
    distance = math.sqrt(least)
    if everywhere:
        index = 0
        while index < POINTS:
            dx, dy = points[index, X] - x, points[index, Y] - y
            away = math.sqrt(dx * dx + dy * dy)
            if away < distance:
                best, distance = index, away
            index += max(1, int((away - distance) / spacing))
    return best, distance


@compiled
def _is_covered(path: PathAhead, index: int, body: _Rectangle) -> bool:
    """Whether the ego's width at a point of the path meets a rectangle, lengthened by its sweep if it crosses."""
    points = path.points
    dx, dy = points[index, X] - body.x, points[index, Y] - body.y
    parallel = abs(points[index, COS] * body.cosine + points[index, SIN] * body.sine)
    crossing = abs(points[index, COS] * body.sine - points[index, SIN] * body.cosine)
    half = points[index, HALF] + body.margin
    extent = body.half_length + half * crossing + (body.sweep if crossing > 0.5 else 0.0)
    if abs(dx * body.cosine + dy * body.sine) >= extent:
        return False
    return bool(abs(dy * body.cosine - dx * body.sine) < body.half_width + half * parallel)


@compiled
def _cover(path: PathAhead, place: int, body: _Rectangle) -> tuple[float, float, float]:
    """Stretch of the path [m ahead] around point ``place`` that a rectangle covers, and the cosine of the headings.

    Returns inf, -inf and 0 where the rectangle keeps clear.
    """
    spacing = path.spacing
    first = place
    if not _is_covered(path, place, body):
        # Not where it is nearest: perhaps with a corner, where the path bends.
        around = int((body.half_length + body.sweep + body.half_width + 2.0 + body.margin) / spacing) + 1
        first, end = max(0, place - around), min(POINTS, place + around + 1)
        while first < end and not _is_covered(path, first, body):
            first += 1
        if first == end:
            return math.inf, -math.inf, 0.0
    last = first
    while first > 0 and _is_covered(path, first - 1, body):
        first -= 1
    while last + 1 < POINTS and _is_covered(path, last + 1, body):
        last += 1
    parallel = path.points[first, COS] * body.cosine + path.points[first, SIN] * body.sine
    return (first - 0.5) * spacing - BEHIND, (last + 0.5) * spacing - BEHIND, parallel


@compiled
def occupy(path: PathAhead, row: Floats, forecast: Floats, margin: float, last: int, out: Floats) -> tuple[int, float]:
    """Fill ``out`` (TIMES, 2) with the stretch that an object covers at each time up to index ``last``.

    Whoever is on the path from the beginning and goes its way is not followed further: its gap says more.
    Returns the first time index at which it is on the path (-1: never) and the cosine between headings there.
    """
    points = path.points
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
        place, distance = _nearest(path, x, y, place, clear > 0.0 or index % _LOOK_AROUND == 0)
        looked, clear = driven, distance - reach
        if clear > 0.0:
            continue
        interval = prediction.FINE_INTERVAL if index <= prediction.FINE else prediction.COARSE_INTERVAL
        sweep = 0.5 * forecast[index, prediction.FSPEED] * interval if index > 0 else 0.0
        # Beside the path: the rectangle's extent across it, and how far the path bends within the rectangle's length.
        along = abs(points[place, COS] * cosine + points[place, SIN] * sine)
        across = abs(points[place, COS] * sine - points[place, SIN] * cosine)
        extent = half_width * along + (half_length + sweep) * across + points[place, HALF] + margin
        if distance > extent + _SLACK + 0.5 * points[place, BEND] * (half_length + 2.0) * (half_length + 2.0):
            continue
        body = _Rectangle(x, y, cosine, sine, half_length, half_width, sweep, margin)
        low, high, along_path = _cover(path, place, body)
        out[index, LOW], out[index, HIGH] = low, high
        if begin < 0 and high > low:
            begin, parallel = index, along_path
            if begin == 0 and parallel > SAME_WAY:
                last = 0
    return begin, parallel
