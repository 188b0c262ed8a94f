"""Bridges and tunnels: roads that cross the ego's route on a map, and that nobody can come from."""

import numpy as np
import shapely

from roadmend.core.route import Route
from roadmend.world.road_network import RoadNetwork


def roads_on_other_levels(network: RoadNetwork, edges: list[str], route: Route) -> frozenset[str]:
    """Edges over or under a route: they cross its lanes and meet it in no junction.

    Many networks know no heights, and those that do know them at few points; whether roads meet, all of them know.

    Args:
        network: that the route is on.
        edges: of the route.
        route: built from them.
    """
    met = {node for name in edges for node in network.edges[name].junctions}
    lines = shapely.MultiLineString([np.column_stack([stage.x, stage.y]) for stage in route.stages])
    way = lines.buffer(0.5 * route.ego_width)
    shapely.prepare(way)
    return frozenset(
        edge.id
        for edge in network.edges.values()
        if edge.junctions
        and met.isdisjoint(edge.junctions)
        and any(
            way.intersects(shapely.LineString(lane.shape).buffer(0.5 * lane.width, cap_style="flat"))
            for lane in edge.lanes
            if len(lane.shape) > 1
        )
    )
