"""The ego's route: a chain of lane centre lines with the windows in which it changes from one to the next."""

import math
from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from roadmend.core.jit import compiled

Floats = NDArray[np.float64]

FAR = 1e8  # [m] no map is larger; beyond it the squares of distances lose all precision
LEAP = 15.0  # [m] farther than anybody comes in a tick, and well within what is searched around the last place


class RightOfWay(IntEnum):
    """Who goes first in a conflict zone; mirrors roadmend_msgs/Route.RULE_*."""

    PRIORITY = 0
    YIELD = 1
    STOP = 2
    SIGNAL = 3
    CROSSING = 4


@compiled
def arc_lengths(x: Floats, y: Floats) -> Floats:
    """Arc length [m] at each of P points, shape (P,)."""
    lengths = np.empty(x.shape[0], dtype=np.float64)
    lengths[0] = 0.0
    for index in range(1, x.shape[0]):
        lengths[index] = lengths[index - 1] + math.hypot(x[index] - x[index - 1], y[index] - y[index - 1])
    return lengths


@compiled
def segment_at(s: Floats, position: float) -> int:
    """Index of the segment of a polyline that holds arc length ``position``; the first or last one beyond its ends."""
    low, high = 0, s.shape[0] - 1
    while high - low > 1:
        middle = (low + high) // 2
        if s[middle] <= position:
            low = middle
        else:
            high = middle
    return low


@compiled
def point_at(x: Floats, y: Floats, s: Floats, position: float) -> tuple[float, float, float]:
    """Point [m] and heading [rad] at arc length ``position``; beyond the ends the line goes straight on."""
    index = segment_at(s, position)
    dx, dy = x[index + 1] - x[index], y[index + 1] - y[index]
    share = (position - s[index]) / (s[index + 1] - s[index])
    return x[index] + share * dx, y[index] + share * dy, math.atan2(dy, dx)


@compiled
def project(x: Floats, y: Floats, s: Floats, px: float, py: float, around: float, reach: float) -> tuple[float, float]:
    """Arc length and signed offset [m] (left positive) of the nearest point of a polyline.

    Only arc lengths within ``reach`` of ``around`` are looked at, so that a route which crosses itself stays
    unambiguous.
    """
    first, last = segment_at(s, around - reach), segment_at(s, around + reach)
    best, best_s, best_offset = np.inf, 0.0, 0.0
    for index in range(first, last + 1):
        dx, dy = x[index + 1] - x[index], y[index + 1] - y[index]
        length = s[index + 1] - s[index]
        share = min(1.0, max(0.0, ((px - x[index]) * dx + (py - y[index]) * dy) / (length * length)))
        ex, ey = px - x[index] - share * dx, py - y[index] - share * dy
        square = ex * ex + ey * ey
        if square < best:
            best = square
            best_s = s[index] + share * length
            best_offset = math.sqrt(square) * (1.0 if dx * ey - dy * ex >= 0.0 else -1.0)
    return best_s, best_offset


@dataclass(frozen=True, slots=True, eq=False)
class Stage:
    """One continuous lane centre line with P points, all arrays of shape (P,)."""

    x: Floats  # [m]
    y: Floats  # [m]
    speed_limit: Floats  # [m/s] that holds from the point on
    s: Floats = field(init=False)  # [m] arc length

    def __post_init__(self) -> None:
        object.__setattr__(self, "s", arc_lengths(self.x, self.y))

    @property
    def length(self) -> float:
        """Arc length of the whole stage [m]."""
        return float(self.s[-1])

    def pose(self, position: float) -> tuple[float, float, float]:
        """Point [m] and heading [rad] at an arc length."""
        return point_at(self.x, self.y, self.s, position)

    def limit_at(self, position: float) -> float:
        """Speed limit [m/s] at an arc length."""
        return float(self.speed_limit[segment_at(self.s, position)])

    def project(self, x: float, y: float, around: float, reach: float = 30.0) -> tuple[float, float]:
        """Arc length and signed offset [m] (left positive) nearest to a point, searched around an arc length."""
        return project(self.x, self.y, self.s, x, y, around, reach)


@dataclass(frozen=True, slots=True)
class Zone:
    """A stretch of the route that others may cross."""

    stage: int
    begin: float  # [m] arc length of the stop line
    end: float  # [m] arc length at which it is left
    rule: RightOfWay
    signal: int = -1  # index into Scene.signals


@dataclass(frozen=True, slots=True)
class Window:
    """Stretch of stage k in which the ego may begin to change to stage k + 1."""

    begin: float  # [m]
    end: float  # [m]


@dataclass(frozen=True, slots=True, eq=False)
class Route:
    """The ego's task: K stages with K - 1 lane changes between them."""

    scenario: str  # name of the scenario
    ego_length: float  # [m]
    ego_width: float  # [m]
    goal: float  # [m] arc length on the last stage at which the task is done
    time_limit: float  # [s]
    stages: tuple[Stage, ...]
    windows: tuple[Window, ...]
    zones: tuple[Zone, ...]

    @property
    def length(self) -> float:
        """Rough length of the way from start to goal [m], for displays and progress."""
        return sum(window.end for window in self.windows) + self.goal

    @property
    def fault(self) -> str:
        """Why nobody can tell a place along it, or an empty string.

        A point, a speed limit, a window or a zone is not finite, or two points that follow each other are one.
        """
        for index, stage in enumerate(self.stages):
            if not (np.all(np.abs(stage.x) < FAR) and np.all(np.abs(stage.y) < FAR)):
                return f"a point of stage {index} is not finite"
            if not np.all(np.diff(stage.s) > 0.0):
                return f"two points of stage {index} that follow each other are one"
            if not np.all(stage.speed_limit >= 0.0):
                return f"a speed limit of stage {index} is no number from 0 on"
        stretches: list[Window | Zone] = [*self.windows, *self.zones]
        if not all(math.isfinite(stretch.begin) and math.isfinite(stretch.end) for stretch in stretches):
            return "a window or a zone is not finite"
        return "its goal is no number" if math.isnan(self.goal) else ""


class RouteTracker:
    """Where on its route somebody is, from their poses in their order alone: a route may cross itself.

    Who turns up LEAP or more away from the last pose was not followed in between, and is looked for on the whole route.
    """

    def __init__(self, route: Route) -> None:
        self.route = route
        self._last = (math.nan, math.nan)  # [m]
        self.places: tuple[tuple[float, float], ...] = ()  # arc length [m], offset [m] (left positive), one a stage

    def observe(self, x: float, y: float) -> int:
        """Take in the next position [m], in the frame of the map; returns the index of the nearest stage."""
        stages = self.route.stages
        is_followed = math.dist(self._last, (x, y)) < LEAP
        self._last = (x, y)
        if is_followed:
            known = zip(stages, self.places, strict=True)
            self.places = tuple(stage.project(x, y, position) for stage, (position, _) in known)
        else:
            self.places = tuple(stage.project(x, y, 0.5 * stage.length, stage.length) for stage in stages)
        return min(range(len(stages)), key=lambda index: abs(self.places[index][1]))
