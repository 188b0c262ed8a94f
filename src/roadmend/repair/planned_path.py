"""The ego's planned path: its lane behind it, the planned trajectory, and the route beyond the trajectory's end.

Positions on it are arc lengths s [m] with 0 at the ego's centre, offsets d [m] are positive to the left.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from roadmend.core.command import Trajectory
from roadmend.core.geometry import wrap_angle
from roadmend.core.jit import compiled, unnamed
from roadmend.core.route import Route, RouteTracker, arc_lengths, point_at, project, segment_at
from roadmend.core.scene import EgoState

Floats = NDArray[np.float64]

BEHIND = 60.0  # [m] of path behind the ego
STEP = 1.5  # [m] between points outside the trajectory
FADE = 20.0  # [m] over which the path beyond the trajectory returns to the lane's centre
ON_ROUTE = 5.0  # [m] a route stage farther away than this says nothing about the ego's path
POINTS = 768  # room for the points of a path
X, Y, S, YAW = 0, 1, 2, 3  # rows of a path's points


class PlannedPath(NamedTuple):
    """One tick's path. ``points`` is a buffer that the next call of the finder overwrites."""

    points: Floats  # rows X, Y [m], S [m], YAW [rad]; only the first ``size`` columns hold
    size: int
    zero: int  # column of the ego's centre
    progress: Floats  # [m] planned arc lengths at 0, interval, 2 interval, ...
    interval: float  # [s]
    tail_speed: float  # [m/s] beyond the end of ``progress``
    stage_positions: Floats  # [m] arc length of the ego on every stage of the route
    stage: int  # the stage that the ego is on


class _Lane(NamedTuple):
    """A stage of the route, and a place on it."""

    x: Floats  # [m]
    y: Floats  # [m]
    s: Floats  # [m]
    position: float  # [m]
    offset: float  # [m]


@compiled
def _lay(
    points: Floats,
    progress: Floats,
    ego: EgoState,
    plan_x: Floats,
    plan_y: Floats,
    near: _Lane,
    end: _Lane,
    ahead: float,
) -> tuple[int, int]:
    """Fill ``points`` (4 x K) and ``progress`` (P + 1); returns the number of points and the index of the ego's.

    ``near`` is where the ego is, ``end`` where about the plan ends.
    """
    ego, near, end = EgoState(*ego), _Lane(*near), _Lane(*end)
    room = points.shape[1]
    count = 0
    for index in range(int(BEHIND / STEP), 0, -1):
        back = index * STEP
        if abs(near.offset) <= ON_ROUTE:
            px, py, heading = point_at(near.x, near.y, near.s, near.position - back)
            points[X, count], points[Y, count] = (
                px - math.sin(heading) * near.offset,
                py + math.cos(heading) * near.offset,
            )
        else:
            points[X, count], points[Y, count] = ego.x - back * math.cos(ego.yaw), ego.y - back * math.sin(ego.yaw)
        count += 1
    zero = count
    points[X, count], points[Y, count] = ego.x, ego.y
    count += 1

    kept = np.empty(progress.shape[0], dtype=np.int64)
    kept[0] = zero
    last_x, last_y, toward_x, toward_y = ego.x, ego.y, math.cos(ego.yaw), math.sin(ego.yaw)
    length = 0.0
    for index in range(plan_x.shape[0]):
        dx, dy = plan_x[index] - last_x, plan_y[index] - last_y
        distance = math.hypot(dx, dy)
        if distance > 0.1 and dx * toward_x + dy * toward_y > 0.0 and count < room - 2:
            points[X, count], points[Y, count] = plan_x[index], plan_y[index]
            last_x, last_y, toward_x, toward_y = plan_x[index], plan_y[index], dx / distance, dy / distance
            length += distance
            count += 1
        kept[index + 1] = count - 1

    final, offset = project(end.x, end.y, end.s, last_x, last_y, end.position, length + 30.0)
    number = max(1, math.ceil((ahead - length) / STEP))
    for index in range(1, number + 1):
        if count >= room:
            break
        on = index * STEP
        if abs(offset) <= ON_ROUTE:
            px, py, heading = point_at(end.x, end.y, end.s, final + on)
            aside = offset * max(0.0, 1.0 - on / FADE)
            points[X, count], points[Y, count] = px - math.sin(heading) * aside, py + math.cos(heading) * aside
        else:
            points[X, count], points[Y, count] = last_x + on * toward_x, last_y + on * toward_y
        count += 1

    s = arc_lengths(points[X, :count], points[Y, :count])
    for index in range(count):
        points[S, index] = s[index] - s[zero]
        before, after = max(0, index - 1), min(count - 1, index + 1)
        points[YAW, index] = math.atan2(points[Y, after] - points[Y, before], points[X, after] - points[X, before])
    points[YAW, zero] = ego.yaw
    for index in range(progress.shape[0]):
        progress[index] = points[S, kept[index]]
    return count, zero


@compiled
def pose_at(points: Floats, size: int, position: float) -> tuple[float, float, float]:
    """As pose_on, for loops: numba counts references to all arrays of a record whenever it is handed on."""
    index = segment_at(points[S, :size], position)
    share = (position - points[S, index]) / (points[S, index + 1] - points[S, index])
    turn = wrap_angle(points[YAW, index + 1] - points[YAW, index])
    return (
        points[X, index] + share * (points[X, index + 1] - points[X, index]),
        points[Y, index] + share * (points[Y, index + 1] - points[Y, index]),
        points[YAW, index] + min(1.0, max(0.0, share)) * turn,
    )


@compiled
def pose_on(path: PlannedPath, position: float) -> tuple[float, float, float]:
    """Point [m] and heading [rad] of the path at an arc length; it goes straight on beyond its ends."""
    return pose_at(path.points, path.size, position)


@compiled
def coordinates_on(path: PlannedPath, x: float, y: float, yaw: float) -> tuple[float, float, float]:
    """Arc length [m], offset [m] and heading relative to the path [rad] of the path's point nearest to a pose."""
    points, count = path.points, path.size
    middle = 0.5 * (points[S, 0] + points[S, count - 1])
    s, d = project(points[X, :count], points[Y, :count], points[S, :count], x, y, middle, math.inf)
    _, _, heading = pose_at(points, count, s)
    return s, d, wrap_angle(yaw - heading)


@compiled
def position_at(progress: Floats, interval: float, tail_speed: float, time: float) -> float:
    """As planned_position, for loops."""
    last = progress.shape[0] - 1
    index = int(time / interval)
    position: float = progress[last] + tail_speed * (time - last * interval)
    if index < last:
        position = progress[index] + (time / interval - index) * (progress[index + 1] - progress[index])
    return position


@compiled
def planned_position(path: PlannedPath, time: float) -> float:
    """Arc length [m] at which the plan has the ego's centre ``time`` [s] from now."""
    return position_at(path.progress, path.interval, path.tail_speed, time)


@compiled
def planned_time(path: PlannedPath, position: float) -> float:
    """Time from now [s] at which the plan has the ego's centre at an arc length; 0 if passed, inf if never."""
    progress, interval = path.progress, path.interval
    last = progress.shape[0] - 1
    if position <= 0.0:
        return 0.0
    for index in range(last):
        if progress[index + 1] >= position:
            share: float = (position - progress[index]) / (progress[index + 1] - progress[index])
            return interval * (index + share)
    if path.tail_speed <= 0.0:
        return math.inf
    time: float = last * interval + (position - progress[last]) / path.tail_speed
    return time


class PathFinder:
    """Lays the planned path of each tick and remembers where on the route the ego is."""

    def __init__(self) -> None:
        self._points = np.zeros((4, POINTS), dtype=np.float64)
        self._tracker: RouteTracker | None = None

    def reset(self, route: Route) -> None:
        """Begin on ``route`` without knowing where."""
        self._tracker = RouteTracker(route)

    def find(self, ego: EgoState, trajectory: Trajectory, ahead: float) -> PlannedPath:
        """The path from 60 m behind the ego to at least ``ahead`` [m] before it.

        Raises:
            RuntimeError: there was no ``reset`` before, or the route has no stage.
        """
        if self._tracker is None or not self._tracker.route.stages:
            raise RuntimeError("a path needs a route with at least one stage")
        stages = self._tracker.route.stages
        size = len(trajectory)
        nearest = self._tracker.observe(ego.x, ego.y)
        positions = tuple(position for position, _ in self._tracker.places)
        final, reach = nearest, 0.0
        if size:
            end_x, end_y = float(trajectory.x[-1]), float(trajectory.y[-1])
            reach = math.hypot(end_x - ego.x, end_y - ego.y)
            if len(stages) > 1:
                ends = [
                    abs(stage.project(end_x, end_y, at + reach, reach + 30.0)[1])
                    for stage, at in zip(stages, positions, strict=True)
                ]
                final = min(range(len(stages)), key=ends.__getitem__)
        near, end = stages[nearest], stages[final]
        progress = np.empty(size + 1, dtype=np.float64)
        count, zero = _lay(
            self._points,
            progress,
            unnamed(ego),
            trajectory.x,
            trajectory.y,
            unnamed(_Lane(near.x, near.y, near.s, *self._tracker.places[nearest])),
            unnamed(_Lane(end.x, end.y, end.s, positions[final] + reach, 0.0)),
            ahead,
        )
        tail_speed = float(trajectory.speed[-1]) if size else ego.speed
        return PlannedPath(
            self._points,
            count,
            zero,
            progress,
            trajectory.interval if size else 1.0,
            max(0.0, tail_speed),
            np.array(positions),
            nearest,
        )
