"""Let the ego join traffic that is under way: a route to drive and a free place to start from."""

import libsumo

from roadmend.core.errors import InputError
from roadmend.world.road_network import RoadNetwork
from roadmend.world.route_builder import check_edge
from roadmend.world.route_draw import draw_start
from roadmend.world.scenario import Scenario
from roadmend.world.scenario_networks import SumoConfiguration
from roadmend.world.traffic_file import EGO

_FREE_AHEAD = 15.0  # [m] between the ego's centre and the rear of whoever is ahead
_FREE_BEHIND = 30.0  # [m] between the ego's centre and the front of whoever is behind
_ENTRY = 40.0  # [m] at the start of an edge where SUMO may put a new vehicle at any time
_STEP = 5.0  # [m] between two places that are tried
_PATIENCE = 120  # [s] of traffic to wait for a free place


def join_traffic(scenario: Scenario, network: RoadNetwork) -> Scenario:
    """The scenario with the ego's route and start filled in; lets traffic run on until there is room.

    Raises:
        InputError: no car is on the road to take a route from, there is no room for the ego, or its name is taken.
    """
    if EGO in libsumo.vehicle.getIDList() or EGO in libsumo.vehicle.getLoadedIDList():
        where = scenario.network.path if isinstance(scenario.network, SumoConfiguration) else "network"
        raise InputError(where, f"has a vehicle {EGO!r} of its own", "give that one another id")
    if isinstance(scenario.network, SumoConfiguration) and scenario.network.draw and not scenario.ego.route:
        return _with_drawn_start(scenario, network, scenario.network)
    ego = scenario.ego
    route = ego.route or _longest_route_under_way()
    check_edge(network, route[0], "ego.route[0]")
    edge = network.edges[route[0]]
    lane = edge.car_lanes[min(ego.lane, len(edge.car_lanes) - 1)]
    for _ in range(_PATIENCE):
        place = _free_place(lane.id, lane.length, ego.position)
        if place is not None:
            return scenario.model_copy(update={"ego": ego.model_copy(update={"route": list(route), "position": place})})
        libsumo.simulation.step(libsumo.simulation.getTime() + 1.0)
    raise InputError("ego.route[0]", f"no room for the ego on {edge.id} within {_PATIENCE} s", "begin on another edge")


def _with_drawn_start(scenario: Scenario, network: RoadNetwork, configuration: SumoConfiguration) -> Scenario:
    is_empty = True
    for _ in range(_PATIENCE):
        start = draw_start(network, scenario)
        if start is not None:
            return scenario.model_copy(update={"ego": scenario.ego.model_copy(update=start._asdict())})
        is_empty = is_empty and libsumo.vehicle.getIDCount() == 0
        libsumo.simulation.step(libsumo.simulation.getTime() + 1.0)
    time = libsumo.simulation.getTime()
    if is_empty:
        raise InputError(configuration.path, f"nobody is on the road until {time:g} s", "choose another --warm-up")
    start = draw_start(network, scenario, anywhere=True)
    if start is not None:
        return scenario.model_copy(update={"ego": scenario.ego.model_copy(update=start._asdict())})
    what = f"no road offers a route to the ego, with room to join the traffic, until {time:g} s"
    raise InputError(configuration.path, what, "choose another --warm-up")


def _longest_route_under_way() -> list[str]:
    routes = [
        list(libsumo.vehicle.getRoute(name))
        for name in libsumo.vehicle.getIDList()
        if libsumo.vehicle.getVehicleClass(name) == "passenger"
    ]
    if not routes:
        raise InputError("ego.route", "no car is on the road to take a route from", "name the edges with --ego-route")
    # Ties are broken by name, so that the choice does not depend on SUMO's order.
    return max(routes, key=lambda route: (len(route), route))


def _free_place(lane: str, length: float, wanted: float) -> float | None:
    """A free arc length [m] on a lane, as near the wanted one as the lane's traffic allows, seen from its start."""
    occupied = [
        (libsumo.vehicle.getLanePosition(name) - libsumo.vehicle.getLength(name), libsumo.vehicle.getLanePosition(name))
        for name in libsumo.lane.getLastStepVehicleIDs(lane)
    ]
    place = max(wanted, min(_ENTRY, 0.5 * length))
    while place < length - _STEP:
        if all(rear - place > _FREE_AHEAD or place - front > _FREE_BEHIND for rear, front in occupied):
            return place
        place += _STEP
    return None
