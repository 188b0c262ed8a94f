"""Whether cars can pass each other on the roads along a route."""

from pathlib import Path

import numpy as np
import pytest

from roadmend.world.clearance import has_clearance
from roadmend.world.road_network import Connection, Edge, Lane, RoadNetwork
from roadmend.world.route_builder import build_route
from roadmend.world.scenario import Ego, Scenario
from roadmend.world.scenario_networks import NetworkFile


def edge(name, begin, end, junctions, function="normal"):
    lane = Lane(f"{name}_0", np.array([begin, end]), 100.0, 13.9, 3.2)
    return Edge(name, function, (lane,), junctions)


def is_clear(*others, connections=()):
    edges = {each.id: each for each in (edge("there", (0.0, 0.0), (100.0, 0.0), ("a", "b")), *others)}
    network = RoadNetwork(Path("none.net.xml"), edges, {("back", 0): list(connections)}, {})
    scenario = Scenario(name="pass", network=NetworkFile(path="none.net.xml"), ego=Ego(route=["there"]))
    return has_clearance(network, ["there"], build_route(network, scenario).route)


@pytest.mark.parametrize(("aside", "expected"), [(3.2, True), (2.1, True), (1.6, False)])
def test_the_other_direction_of_the_road_needs_the_width_of_two_cars(aside, expected):
    assert is_clear(edge("back", (100.0, aside), (0.0, aside), ("b", "a"))) is expected


def test_who_goes_the_same_way_or_meets_the_road_nowhere_is_no_matter():
    assert is_clear(edge("beside", (0.0, 1.6), (100.0, 1.6), ("a", "b")))
    assert is_clear(edge("bridge", (100.0, 1.6), (0.0, 1.6), ("c", "d")))


@pytest.mark.parametrize(("state", "direction", "expected"), [("M", "s", False), ("m", "s", True), ("M", "l", True)])
def test_inside_a_junction_those_who_give_way_or_turn_left_are_no_matter(state, direction, expected):
    inside = edge(":a_0", (20.0, 1.6), (0.0, 1.6), ("a",), "internal")
    through = Connection("back", "out", 0, 0, ":a_0_0", state, direction, "", -1)
    assert is_clear(inside, connections=[through]) is expected
