"""Roads on which two cars cannot pass each other: lanes drawn too near to one another, though nobody has to give way.

SUMO looks along lanes and sees no contact there; outlines do touch, and none of the drivers could have helped it.
"""

import functools
import math

import numpy as np
import shapely

from roadmend.core.geometry import wrap_angle
from roadmend.core.route import Route
from roadmend.world.road_network import Lane, RoadNetwork

_OTHER = 1.8  # [m] width of a car
_MARGIN = 0.15  # [m] that bends take
_OPPOSITE = math.radians(135.0)  # between headings from here on
_SAMPLE = 0.5  # [m] over which a lane's direction is taken


def has_clearance(network: RoadNetwork, edges: list[str], route: Route) -> bool:
    """Whether cars that come the other way can pass the ego all along a route.

    Args:
        network: that the route is on.
        edges: of the route.
        route: built from them.
    """
    lanes, tree = _lanes_to_pass(network)
    way = shapely.MultiLineString([np.column_stack([stage.x, stage.y]) for stage in route.stages])
    stages = shapely.get_parts(way)
    near = 0.5 * (route.ego_width + _OTHER) + _MARGIN
    own, met = set(edges), {node for name in edges for node in network.edges[name].junctions}
    for index in tree.query(way, predicate="dwithin", distance=near):
        lane = lanes[index]
        edge = network.edges[lane.id.rpartition("_")[0]]
        if edge.id in own or met.isdisjoint(edge.junctions):
            continue
        line = shapely.LineString(lane.shape)
        if any(stage.distance(line) < near and _comes_the_other_way(stage, line) for stage in stages):
            return False
    return True


@functools.lru_cache(maxsize=8)
def _lanes_to_pass(network: RoadNetwork) -> tuple[list[Lane], shapely.STRtree]:
    """The lanes of roads, and those inside junctions on which nobody gives way or turns left."""
    straight = {
        connection.via
        for connections in network.connections.values()
        for connection in connections
        if connection.state == "M" and connection.direction in {"s", "r", "R"}
    }
    lanes = [
        lane
        for edge in network.edges.values()
        for lane in edge.lanes
        if lane.for_cars and len(lane.shape) > 1 and (edge.function == "normal" or lane.id in straight)
    ]
    return lanes, shapely.STRtree([shapely.LineString(lane.shape) for lane in lanes])


def _comes_the_other_way(stage: shapely.LineString, line: shapely.LineString) -> bool:
    """Whether two lines lead in opposite directions where they are nearest."""
    point, other = (shapely.Point(place) for place in shapely.shortest_line(stage, line).coords)
    turn = wrap_angle(_heading(stage, point) - _heading(line, other))
    return abs(turn) > _OPPOSITE


def _heading(line: shapely.LineString, point: shapely.Point) -> float:
    """Direction [rad] of a line at a point on it."""
    place = line.project(point)
    begin, end = (line.interpolate(max(0.0, place + step)) for step in (-_SAMPLE, _SAMPLE))
    return math.atan2(end.y - begin.y, end.x - begin.x)
