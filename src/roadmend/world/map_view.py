"""The road network as drawings and messages need it: lane centre lines by kind, as a structure of arrays."""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from roadmend.world.road_network import Edge, Lane, RoadNetwork

Floats = NDArray[np.float64]


class LaneKind(IntEnum):
    """Mirrors roadmend_msgs/Map.KIND_*."""

    ROAD = 0
    JUNCTION = 1
    WALK = 2


@dataclass(frozen=True, slots=True, eq=False)
class LaneMap:
    """Lane centre lines: L lanes with P points altogether, frame map."""

    begin: NDArray[np.int64]  # index of the first point of each lane, shape (L,)
    kind: NDArray[np.uint8]  # LaneKind, shape (L,)
    width: Floats  # [m] shape (L,)
    x: Floats  # [m] shape (P,)
    y: Floats  # [m] shape (P,)

    def lines(self, kind: LaneKind) -> tuple[list[Floats], Floats]:
        """Centre lines (shape (p, 2) each) and widths [m] of all lanes of one kind that have two points or more."""
        ends = np.append(self.begin[1:], len(self.x))
        points = np.column_stack((self.x, self.y))
        chosen = [index for index in np.flatnonzero(self.kind == kind) if ends[index] - self.begin[index] > 1]
        return [points[self.begin[index] : ends[index]] for index in chosen], self.width[chosen]


def lanes_of(network: RoadNetwork) -> LaneMap:
    """All lanes that have a length."""
    lanes = [(edge, lane) for edge in network.edges.values() for lane in edge.lanes if len(lane.shape) >= 2]
    points = np.concatenate([lane.shape for _, lane in lanes]) if lanes else np.empty((0, 2), dtype=np.float64)
    counts = [len(lane.shape) for _, lane in lanes]
    return LaneMap(
        np.cumsum([0, *counts], dtype=np.int64)[:-1],
        np.array([_kind(edge, lane) for edge, lane in lanes], dtype=np.uint8),
        np.array([lane.width for _, lane in lanes], dtype=np.float64),
        np.ascontiguousarray(points[:, 0]),
        np.ascontiguousarray(points[:, 1]),
    )


def _kind(edge: Edge, lane: Lane) -> LaneKind:
    if lane.for_pedestrians_only or edge.function in ("crossing", "walkingarea"):
        return LaneKind.WALK
    return LaneKind.JUNCTION if edge.function == "internal" else LaneKind.ROAD
