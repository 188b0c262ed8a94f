"""The road network as drawings need it: centre lines by kind."""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from roadmend.world.road_network import Edge, Lane, RoadNetwork


class LaneKind(IntEnum):
    """Mirrors roadmend_msgs/Map.KIND_*."""

    ROAD = 0
    JUNCTION = 1
    WALK = 2


@dataclass(frozen=True, slots=True, eq=False)
class DrawnLane:
    """One lane; ``shape`` is its centre line, P x 2 [m]."""

    kind: LaneKind
    width: float  # [m]
    shape: NDArray[np.float64]


def lanes_of(network: RoadNetwork) -> tuple[DrawnLane, ...]:
    """All lanes that have a length."""
    return tuple(
        DrawnLane(_kind(edge, lane), lane.width, lane.shape)
        for edge in network.edges.values()
        for lane in edge.lanes
        if len(lane.shape) >= 2
    )


def _kind(edge: Edge, lane: Lane) -> LaneKind:
    if lane.for_pedestrians_only or edge.function in ("crossing", "walkingarea"):
        return LaneKind.WALK
    return LaneKind.JUNCTION if edge.function == "internal" else LaneKind.ROAD
