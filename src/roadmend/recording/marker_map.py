"""What does not move: lanes, the ego's route, its windows and conflict zones, and the goal."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roadmend.core.appearance import GOAL_COLOUR, ROUTE_COLOUR, RULE_COLOUR, WINDOW_COLOUR
from roadmend.core.route import Route, Stage
from roadmend.recording.marker_parts import (
    Shape,
    colour_of,
    complete_picture,
    line_of,
    marker_of,
    points_of,
    pose_of,
    text_of,
)
from roadmend.world.road_network import LaneKind, LaneMap

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

MITER_MAX = 2.0  # how far a band's corner may stick out, in half widths
ROUTE_LANE_WIDTH = 3.2  # [m] of the lines drawn across the route
EDGE_WIDTH = 0.12  # [m]

_SURFACES = {  # kind: namespace, colour, height [m] (apart, or a display flickers between them)
    LaneKind.ROAD: ("road", "#3d4450", -0.06),
    LaneKind.JUNCTION: ("junction", "#4a5160", -0.04),
    LaneKind.WALK: ("walk", "#6e675c", -0.02),
}


def map_markers(lanes: LaneMap | None, route: Route | None, header: Any) -> Any:
    """Lanes as surfaces with edges, and the route on top of them; either may be missing.

    A handful of markers holds any number of lanes, and neighbouring triangles share their points, so that 3000 lanes
    cost about a tenth of a second, once an episode.

    Raises:
        ValueError: the arrays of the map do not fit together.
    """
    markers: list[Any] = []
    if lanes is not None:
        markers += lane_markers(lanes, header)
    if route is not None:
        markers += route_markers(route, header)
    return complete_picture(header, markers)


def lane_markers(lanes: LaneMap, header: Any) -> list[Any]:
    """One TRIANGLE_LIST for each kind of lane and one LINE_LIST for the edges of all roads.

    Raises:
        ValueError: the arrays of the map do not fit together.
    """
    x, y, begin, kind, width = lanes.x, lanes.y, lanes.begin, lanes.kind, lanes.width
    if not len(x) == len(y) or not len(begin) == len(kind) == len(width):
        raise ValueError("map: the arrays differ in length")
    if not len(begin) or not len(x):
        return []
    counts = np.diff(begin, append=len(x))
    if begin[0] != 0 or (counts < 0).any():
        raise ValueError("map: the lanes' begins do not rise from 0 to the number of points")
    lane = np.repeat(np.arange(len(begin)), counts)
    left, right, joined = band_edges(x, y, lane, 0.5 * width[lane])
    left_points, right_points = _flat_points(left), _flat_points(right)
    found = []
    for code, (namespace, colour, z) in _SURFACES.items():
        segments = np.flatnonzero(joined & (kind[lane[:-1]] == code)).tolist()
        if segments:
            corners = [
                corner
                for i in segments
                for corner in (
                    left_points[i],
                    right_points[i],
                    right_points[i + 1],
                    left_points[i],
                    right_points[i + 1],
                    left_points[i + 1],
                )
            ]
            pose, scale = pose_of(0.0, 0.0, z), (1.0, 1.0, 1.0)
            group, paint = (namespace, 0), colour_of(colour)
            found.append(marker_of(header, group, Shape.TRIANGLE_LIST, paint, scale, pose=pose, points=corners))
    segments = np.flatnonzero(joined & (kind[lane[:-1]] == LaneKind.ROAD)).tolist()
    if segments:
        ends = [
            end for i in segments for end in (left_points[i], left_points[i + 1], right_points[i], right_points[i + 1])
        ]
        scale = (EDGE_WIDTH, 0.0, 0.0)
        found.append(marker_of(header, ("edges", 0), Shape.LINE_LIST, colour_of("#aeb4bf", 0.55), scale, points=ends))
    return found


def band_edges(x: Floats, y: Floats, lane: NDArray[np.int64], half_width: Floats) -> tuple[Floats, Floats, Flags]:
    """Left and right edge of bands around centre lines.

    Args:
        x: points of all centre lines, one after another, shape (P,) [m].
        y: likewise.
        lane: which line each point belongs to, shape (P,).
        half_width: half the width of the band at each point, shape (P,) [m].

    Returns:
        Left edge and right edge, shape (P, 2) each, and which consecutive points are joined, shape (P - 1,); points
        that are not finite and lines of zero length are joined to nothing.
    """
    points = np.column_stack((x, y))
    step = np.diff(points, axis=0)
    length = np.hypot(step[:, 0], step[:, 1])
    joined: Flags = (lane[1:] == lane[:-1]) & np.isfinite(length) & (length > 1e-6)
    joined &= np.isfinite(half_width[1:]) & np.isfinite(half_width[:-1])
    unit = np.zeros_like(step)
    unit[joined] = step[joined] / length[joined, None]
    along, sides = np.zeros_like(points), np.zeros(len(points))
    for part in (slice(None, -1), slice(1, None)):
        along[part] += unit
        sides[part] += joined
    norm = np.maximum(np.hypot(along[:, 0], along[:, 1]), 1e-9)
    reach = half_width * np.minimum(sides / norm, MITER_MAX) / norm
    across = np.column_stack((-along[:, 1] * reach, along[:, 0] * reach))
    return points + across, points - across, joined


def route_markers(route: Route, header: Any) -> list[Any]:
    """Stages, windows, conflict zones with their stop lines, and the goal."""
    found: list[Any] = []
    for index, stage in enumerate(route.stages):
        colour = colour_of(ROUTE_COLOUR, 0.9)
        found.append(line_of(header, ("route", index), (stage.x, stage.y), z=0.02, width=0.35, colour=colour))
    for index, window in enumerate(route.windows):
        stretch = stretch_of(route.stages[index], window.begin, window.end)
        colour = colour_of(WINDOW_COLOUR, 0.45)
        found.append(line_of(header, ("windows", index), stretch, z=0.01, width=1.2, colour=colour))
    for index, zone in enumerate(route.zones):
        stage, colour = route.stages[zone.stage], RULE_COLOUR[zone.rule]
        stretch = stretch_of(stage, zone.begin, zone.end)
        found.append(line_of(header, ("zones", index), stretch, z=0.03, width=1.2, colour=colour_of(colour, 0.45)))
        bar = bar_across(stage, zone.begin)
        found.append(line_of(header, ("stop_lines", index), bar, z=0.05, width=0.4, colour=colour_of(colour)))
    if route.stages:
        found += _goal(route, header)
    return found


def _goal(route: Route, header: Any) -> Iterator[Any]:
    stage, colour = route.stages[-1], colour_of(GOAL_COLOUR)
    yield line_of(header, ("goal", 0), bar_across(stage, route.goal), z=0.06, width=0.6, colour=colour)
    x, y, _ = stage.pose(route.goal)
    yield text_of(header, ("goal", 1), "goal", at=(x, y, 2.0), height=1.4, colour=colour)


def stretch_of(stage: Stage, begin: float, end: float) -> tuple[Floats, Floats]:
    """The part of a stage between two arc lengths [m], with both ends exact, as x and y."""
    inside = (stage.s > begin) & (stage.s < end)
    first, last = stage.pose(begin), stage.pose(end)
    return (
        np.concatenate(([first[0]], stage.x[inside], [last[0]])),
        np.concatenate(([first[1]], stage.y[inside], [last[1]])),
    )


def bar_across(stage: Stage, position: float) -> tuple[Floats, Floats]:
    """A line across the lane at an arc length [m], left end first, as x and y."""
    x, y, yaw = stage.pose(position)
    offset = 0.5 * ROUTE_LANE_WIDTH * np.array([1.0, -1.0])
    return x - offset * np.sin(yaw), y + offset * np.cos(yaw)


def _flat_points(values: Floats) -> list[Any]:
    return points_of(values[:, 0], values[:, 1], 0.0)
