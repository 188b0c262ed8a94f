"""The route as compiled code reads it: every stage sampled evenly, with the speed that it allows."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from roadmend.core import portable_math
from roadmend.core.jit import compiled
from roadmend.core.route import Route, Stage
from roadmend.policies.parameters import ModularParameters

Floats = NDArray[np.float64]

SPACING = 1.0  # [m] between the samples of a stage
_CURVE_REACH = 2  # samples to either side over which curvature is measured

# Columns of Road.samples
X, Y, COS, SIN, CURVATURE, SPEED = range(6)  # [m], [m], heading, heading, [1/m], [m/s]
# Columns of Road.stages
FIRST, COUNT, LENGTH, WINDOW_BEGIN, WINDOW_END = range(5)  # sample, samples, [m], [m], [m]
# Columns of Road.zones
STAGE, BEGIN, END, RULE, SIGNAL = range(5)  # stage, [m], [m], RightOfWay, index of the light or -1


class RouteTables(NamedTuple):
    """A route in three tables."""

    samples: Floats  # all stages one after another, see the columns above
    stages: Floats  # one row a stage; a window that is not there begins at infinity
    zones: Floats  # one row a zone, by stage and begin

    @classmethod
    def of(cls, route: Route, parameters: ModularParameters) -> "RouteTables":
        """Sample a route."""
        tables = [_sample(stage, parameters) for stage in route.stages]
        stages = np.full((len(tables), 5), math.inf)
        first = 0
        for index, table in enumerate(tables):
            stages[index, :3] = first, len(table), route.stages[index].length
            first += len(table)
        for index, window in enumerate(route.windows):
            stages[index, WINDOW_BEGIN:] = window.begin, window.end
        zones = np.array(
            [(zone.stage, zone.begin, zone.end, int(zone.rule), zone.signal) for zone in route.zones], dtype=np.float64
        ).reshape(-1, 5)
        return cls(np.concatenate(tables), stages, zones)


def _sample(stage: Stage, parameters: ModularParameters) -> Floats:
    count = max(2, math.ceil(stage.length / SPACING) + 1)
    table = np.empty((count, 6))
    _fill_shape(table, stage.x, stage.y, stage.s)
    segments = np.clip(np.searchsorted(stage.s, np.arange(count) * SPACING, side="right") - 1, 0, len(stage.s) - 1)
    _fill_speed(table, stage.speed_limit[segments], parameters.lateral_acceleration, parameters.deceleration)
    return table


def _fill_shape(table: Floats, x: Floats, y: Floats, s: Floats) -> None:
    count = len(table)
    places = np.minimum(np.arange(count) * SPACING, s[-1])
    table[:, X], table[:, Y] = np.interp(places, s, x), np.interp(places, s, y)
    # The last sample lies past the end, straight on, so that arc length and index stay proportional.
    before = np.hypot(x[-1] - x[-2], y[-1] - y[-2])
    beyond = (count - 1) * SPACING - s[-1]
    table[-1, X] += beyond * (x[-1] - x[-2]) / before
    table[-1, Y] += beyond * (y[-1] - y[-2]) / before
    dx, dy = np.gradient(table[:, X]), np.gradient(table[:, Y])
    headings = portable_math.atan2(dy, dx)
    table[:, COS], table[:, SIN] = portable_math.cos(headings), portable_math.sin(headings)
    turned = np.unwrap(headings)
    low, high = np.maximum(np.arange(count) - _CURVE_REACH, 0), np.minimum(np.arange(count) + _CURVE_REACH, count - 1)
    table[:, CURVATURE] = (turned[high] - turned[low]) / ((high - low) * SPACING)


def _fill_speed(table: Floats, limit: Floats, lateral: float, deceleration: float) -> None:
    """The speed that limits and curves allow, lowered ahead of slower stretches so that they are reached gently."""
    allowed = np.minimum(limit, np.sqrt(lateral / np.maximum(np.abs(table[:, CURVATURE]), 1e-6)))
    for index in range(len(table) - 2, -1, -1):
        allowed[index] = min(allowed[index], math.sqrt(allowed[index + 1] ** 2 + 2.0 * deceleration * SPACING))
    table[:, SPEED] = allowed


@compiled
def pose_on(
    samples: Floats, first: int, count: int, position: float
) -> tuple[float, float, float, float, float, float]:
    """x, y [m], cosine and sine of the heading, curvature [1/m] and speed [m/s] at an arc length; beyond the ends straight on."""
    place = position / SPACING
    index = min(max(math.floor(place), 0), count - 2)
    share = place - index
    row = first + index
    inside = min(max(share, 0.0), 1.0)
    x = samples[row, X] + share * (samples[row + 1, X] - samples[row, X])
    y = samples[row, Y] + share * (samples[row + 1, Y] - samples[row, Y])
    cosine = samples[row, COS] + inside * (samples[row + 1, COS] - samples[row, COS])
    sine = samples[row, SIN] + inside * (samples[row + 1, SIN] - samples[row, SIN])
    scale = 1.0 / math.sqrt(cosine * cosine + sine * sine)
    curvature = samples[row, CURVATURE] + inside * (samples[row + 1, CURVATURE] - samples[row, CURVATURE])
    speed = samples[row, SPEED] + inside * (samples[row + 1, SPEED] - samples[row, SPEED])
    return x, y, cosine * scale, sine * scale, curvature, speed


@compiled
def project_on(
    samples: Floats, first: int, count: int, px: float, py: float, around: float, reach: float
) -> tuple[float, float]:
    """Arc length and signed offset [m] (left positive) of a point, searched within ``reach`` [m] of ``around`` [m].

    The stage goes straight on beyond its ends: arc lengths may be negative or longer than the stage.
    """
    low = min(max(int((around - reach) / SPACING), 0), count - 2)
    high = min(max(int((around + reach) / SPACING), low), count - 2)
    nearest, best = low, math.inf
    index = low
    while index <= high + 1:
        dx, dy = px - samples[first + index, X], py - samples[first + index, Y]
        square = dx * dx + dy * dy
        if square < best:
            best, nearest = square, index
        # No sample nearer than the best one so far can lie within this leap.
        leap = (math.sqrt(square) - math.sqrt(best)) / SPACING
        index += max(1, int(leap))
    result_s, result_offset, least = 0.0, 0.0, math.inf
    for segment in range(max(nearest - 1, 0), min(nearest, count - 2) + 1):
        row = first + segment
        dx, dy = samples[row + 1, X] - samples[row, X], samples[row + 1, Y] - samples[row, Y]
        length = math.sqrt(dx * dx + dy * dy)
        ex, ey = px - samples[row, X], py - samples[row, Y]
        share = (ex * dx + ey * dy) / (length * length)
        lowest = -math.inf if segment == 0 else 0.0
        highest = math.inf if segment == count - 2 else 1.0
        share = min(max(share, lowest), highest)
        fx, fy = ex - share * dx, ey - share * dy
        square = fx * fx + fy * fy
        if square < least:
            least = square
            result_s = (segment + share) * SPACING
            result_offset = math.sqrt(square) if dx * ey - dy * ex >= 0.0 else -math.sqrt(square)
    return result_s, result_offset
