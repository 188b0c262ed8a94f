"""Exact geometry of vehicle outlines: oriented rectangles in the map frame (ENU, metres, radians)."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roadmend.core.jit import compiled
from roadmend.core.scene import EgoState, ObjectList, Objects

Floats = NDArray[np.float64]
Outline = Any  # what has x, y [m], yaw [rad], length and width [m]: the ego's state, or a participant's record

DISTANCE_EXACT = 60.0  # [m] up to which the nearest distance is that between outlines


@compiled
def wrap_angle(angle: float) -> float:
    """Bring an angle [rad] into (-pi, pi]."""
    wrapped = (angle + math.pi) % (2.0 * math.pi) - math.pi
    return math.pi if wrapped == -math.pi else wrapped


@compiled
def fill_corners(corners: Floats, x: float, y: float, yaw: float, length: float, width: float) -> None:
    """Write the four corners of an outline into ``corners`` (shape 4 x 2), counter-clockwise from front left."""
    cosine, sine = math.cos(yaw), math.sin(yaw)
    along_x, along_y = 0.5 * length * cosine, 0.5 * length * sine
    across_x, across_y = -0.5 * width * sine, 0.5 * width * cosine
    corners[0, 0], corners[0, 1] = x + along_x + across_x, y + along_y + across_y
    corners[1, 0], corners[1, 1] = x - along_x + across_x, y - along_y + across_y
    corners[2, 0], corners[2, 1] = x - along_x - across_x, y - along_y - across_y
    corners[3, 0], corners[3, 1] = x + along_x - across_x, y + along_y - across_y


@compiled
def fill_outline(corners: Floats, body: Outline) -> None:
    """Write the four corners of a body's outline into ``corners`` (shape 4 x 2), in the order of fill_corners."""
    fill_corners(corners, body.x, body.y, body.yaw, body.length, body.width)


@compiled
def _point_segment_squared(px: float, py: float, ax: float, ay: float, bx: float, by: float) -> float:
    dx, dy = bx - ax, by - ay
    square = dx * dx + dy * dy
    share = 0.0
    if square > 0.0:
        share = min(1.0, max(0.0, ((px - ax) * dx + (py - ay) * dy) / square))
    ex, ey = ax + share * dx - px, ay + share * dy - py
    return ex * ex + ey * ey


@compiled
def _separated(first: Floats, second: Floats) -> bool:
    """Separating-axis test over the edge normals of ``first``."""
    for edge in range(2):
        normal_x = first[edge + 1, 1] - first[edge, 1]
        normal_y = first[edge, 0] - first[edge + 1, 0]
        low_first, high_first, low_second, high_second = np.inf, -np.inf, np.inf, -np.inf
        for corner in range(4):
            projection = normal_x * first[corner, 0] + normal_y * first[corner, 1]
            low_first, high_first = min(low_first, projection), max(high_first, projection)
            projection = normal_x * second[corner, 0] + normal_y * second[corner, 1]
            low_second, high_second = min(low_second, projection), max(high_second, projection)
        if high_first < low_second or high_second < low_first:
            return True
    return False


@compiled
def corner_distance(first: Floats, second: Floats) -> float:
    """Distance [m] between two rectangles given by their corners (4 x 2 each); 0 where they touch or overlap."""
    if not _separated(first, second) and not _separated(second, first):
        return 0.0
    best = np.inf
    for corner in range(4):
        for edge in range(4):
            after = (edge + 1) % 4
            best = min(
                best,
                _point_segment_squared(
                    first[corner, 0],
                    first[corner, 1],
                    second[edge, 0],
                    second[edge, 1],
                    second[after, 0],
                    second[after, 1],
                ),
                _point_segment_squared(
                    second[corner, 0],
                    second[corner, 1],
                    first[edge, 0],
                    first[edge, 1],
                    first[after, 0],
                    first[after, 1],
                ),
            )
    return math.sqrt(best)


@compiled
def outline_distances(own: Outline, others: Objects, near: float) -> Floats:
    """Distances [m] from one outline to each of N others, shape (N,).

    Exact where the gap between the circumscribed circles is below ``near`` [m]; elsewhere that gap itself, which is
    a lower bound no smaller than ``near``.
    """
    count = others.shape[0]
    distances = np.empty(count, dtype=np.float64)
    corners = np.empty((4, 2), dtype=np.float64)
    their = np.empty((4, 2), dtype=np.float64)
    fill_outline(corners, own)
    own_radius = 0.5 * math.hypot(own.length, own.width)
    for index in range(count):
        other = others[index]
        gap = math.hypot(other.x - own.x, other.y - own.y)
        gap -= own_radius + 0.5 * math.hypot(other.length, other.width)
        if gap < near:
            fill_outline(their, other)
            gap = corner_distance(corners, their)
        distances[index] = gap
    return distances


def nearest_distance(ego: EgoState, objects: ObjectList) -> float:
    """Gap [m] between the ego's outline and the nearest other, exact up to DISTANCE_EXACT; infinite where is none."""
    distances = outline_distances(ego, objects.table, DISTANCE_EXACT)
    return float(np.nanmin(distances)) if np.isfinite(distances).any() else math.inf
