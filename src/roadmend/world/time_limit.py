"""How long a route may take: a time limit for those that nobody has given one."""

import math

from roadmend.core.errors import InputError
from roadmend.world.network import network_file
from roadmend.world.road_network import read_network
from roadmend.world.route_builder import build_route
from roadmend.world.scenario import Scenario

_PACE = 0.85  # of the speed limit, in light traffic
_AT_LIGHTS = 30.0  # [s] that a traffic light takes
_PATIENCE = 2.0  # times that, for traffic that is not light
_START = 30.0  # [s] to get going
_ROUNDED = 10.0  # [s]


def time_for_route(scenario: Scenario) -> float:
    """Time [s] in which a careful driver comes to the end of the scenario's route, in traffic too.

    Raises:
        InputError: there is no such route in the network, or the network cannot be read.
    """
    network = read_network(network_file(scenario.network))
    built = build_route(network, scenario)
    lanes = [network.edges[name].car_lanes[0] for name in scenario.ego.route]
    for lane in lanes:
        if lane.speed_limit <= 0.0:
            raise InputError(
                "ego.route", f"nobody may drive on {lane.id}, whose speed limit is 0", "choose another way"
            )
    driving = sum(lane.length / (_PACE * lane.speed_limit) for lane in lanes)
    light = driving + _AT_LIGHTS * len(built.signals)
    return _ROUNDED * math.ceil((_START + _PATIENCE * light) / _ROUNDED)
