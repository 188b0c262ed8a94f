"""Actors whom SUMO would not let onto the road are refused by their field, before SUMO begins."""

from dataclasses import replace

import pytest

from roadmend.core.errors import InputError
from roadmend.world.families import sample_scenario
from roadmend.world.network import network_file
from roadmend.world.road_network import read_network
from roadmend.world.scenario_actors import Vehicle
from roadmend.world.traffic_file import traffic_xml

SCENARIO = sample_scenario("S3", 0)
ROUTE = ["south_in", "north_out"]


def traffic(kind, closed, **permission):
    """The route file of one actor where the lanes of an edge have another permission."""
    network = read_network(network_file(SCENARIO.network))
    lanes = tuple(replace(lane, **permission) for lane in network.edges[closed].lanes)
    network = replace(network, edges=network.edges | {closed: replace(network.edges[closed], lanes=lanes)})
    actor = Vehicle(id="one", kind=kind, route=ROUTE)
    return traffic_xml(SCENARIO.model_copy(update={"actors": [actor]}), network)


@pytest.mark.parametrize("permission", [{"disallow": ("bicycle",)}, {"allow": ("passenger", "bus")}])
def test_a_lane_that_is_closed_to_the_actor_is_named(permission):
    with pytest.raises(InputError, match=r"actors\[0\]\.route\[1\]: no lane leads .* that is open to a bicycle"):
        traffic("bicycle", "south_in", **permission)
    with pytest.raises(InputError, match=r"actors\[0\]\.route\[1\]: no lane leads .* that is open to a bicycle"):
        traffic("bicycle", "north_out", **permission)
    assert 'id="one"' in traffic("suv", "south_in", **permission)


def test_of_several_lanes_the_one_that_is_closed_to_the_actor_is_named():
    network = read_network(network_file(SCENARIO.network))
    edge = network.edges["south_in"]
    number = edge.lane_number(0)
    lanes = tuple(replace(lane, disallow=("bus",)) if at == number else lane for at, lane in enumerate(edge.lanes))
    network = replace(network, edges=network.edges | {"south_in": replace(edge, lanes=lanes)})
    actor = Vehicle(id="one", kind="bus", route=["south_in"])
    with pytest.raises(InputError, match=r"actors\[0\]\.lane: 0 of south_in is closed to a bus; choose another lane"):
        traffic_xml(SCENARIO.model_copy(update={"actors": [actor]}), network)
