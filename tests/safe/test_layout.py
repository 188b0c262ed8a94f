"""The five road types, with the lanes, the stem and the ramp that a report gives."""

import math
import random

import pytest

from roadmend.safe.layout import lay_out
from roadmend.safe.open_questions import answer, open_questions
from roadmend.safe.ways import MPH
from roadmend.world.network import network_file
from roadmend.world.road_network import read_network
from roadmend.world.space import sample

from .crashes import ALL, crash, vehicle


def layout_of(what, **fixed):
    drawn = sample(open_questions(what), random.Random(3)) | fixed
    return lay_out(answer(what, drawn), drawn)


def lanes_of(layout):
    return {edge.id: len(edge.car_lanes) for edge in read_network(network_file(layout.network)).roads}


def test_a_straight_road_has_its_lanes_in_two_directions():
    layout = layout_of(crash("Straight", vehicle("N2S"), vehicle("S2N"), lanes=5))
    assert lanes_of(layout) == {"forward": 3, "backward": 2}
    assert [way.route for way in layout.ways] == [("forward",), ("backward",)]
    assert layout.network.bearing == 270.0
    assert layout.ways[0].limit == pytest.approx(35 * MPH, abs=0.01)


def test_one_lane_for_both_directions_becomes_one_each_and_is_said():
    layout = layout_of(crash("Straight", vehicle("N2S"), vehicle("S2N"), lanes=1))
    assert lanes_of(layout) == {"forward": 1, "backward": 1}
    assert "one lane" in layout.adapted[0]
    assert lanes_of(layout_of(crash("Straight", vehicle("N2S"), lanes=1))) == {"forward": 1}


def test_a_curve_bends_and_one_that_joins_two_compass_directions_bends_by_their_angle():
    assert layout_of(ALL["curve"], bend="left", bend_angle=45).network.bend == 45.0
    assert layout_of(ALL["curve"], bend="right", bend_angle=45).network.bend == -45.0
    corner = layout_of(crash("Curve", vehicle("W2E"), vehicle("N2S")))
    assert corner.network.bend == 90.0
    assert [way.route for way in corner.ways] == [("forward",), ("backward",)]


def test_an_intersection_has_four_arms_and_the_larger_road_has_the_lanes():
    layout = layout_of(
        crash("Intersection", vehicle("W2E"), vehicle("S2N", "Turn Left"), lanes=4),
        control="first_major",
        crossing_road="two_lanes",
    )
    lanes = lanes_of(layout)
    assert {name: lanes[name] for name in ("west_in", "east_out", "south_in", "north_out")} == {
        "west_in": 2,
        "east_out": 2,
        "south_in": 1,
        "north_out": 1,
    }
    assert [way.route for way in layout.ways] == [("west_in", "east_out"), ("south_in", "west_out")]
    assert [arm.major for arm in layout.network.arms if arm.name in ("east", "north")] == [True, False]


def test_a_tee_has_its_stem_and_no_fourth_arm_unless_a_vehicle_needs_it():
    layout = layout_of(ALL["tee"])
    assert [arm.name for arm in layout.network.arms] == ["east", "north", "south"]
    assert layout.adapted == ()
    wrong = layout_of(crash("T-intersection", vehicle("W2E"), vehicle("S2N"), stem="North"))
    assert layout.is_junction
    assert [arm.name for arm in wrong.network.arms] == ["east", "north", "west", "south"]
    assert "stem in the North" in wrong.adapted[0]


def test_a_stem_that_is_open_suits_the_vehicles():
    space = open_questions(crash("T-intersection", vehicle("W2E"), vehicle("S2N", "Turn Left")))
    assert [*space["stem"].weights] == ["South"]


def test_a_turn_on_a_straight_road_gets_it_a_side_road():
    layout = layout_of(ALL["driveway"])
    assert layout.is_junction
    assert "driveway" in layout.adapted[0]


def test_merging_has_a_ramp_and_half_of_the_main_roads_lanes():
    layout = layout_of(ALL["merging"])
    assert lanes_of(layout) == {"approach": 2, "ramp": 1, "merge": 3, "mainline": 2}
    assert [way.route[0] for way in layout.ways] == ["approach", "ramp"]


@pytest.mark.parametrize("name", ALL)
def test_ways_lead_through_the_network(name):
    layout = layout_of(ALL[name])
    net = read_network(network_file(layout.network))
    for way in layout.ways:
        assert way.lanes
        assert 0.0 < way.length <= way.meeting or len(way.route) == 1
        for lane in way.lanes:
            links = net.connections.get((way.route[0], net.edges[way.route[0]].lane_number(lane)), [])
            assert len(way.route) == 1 or any(link.to_edge == way.route[1] for link in links)
        assert math.isfinite(way.heading + way.turn)


def test_a_single_vehicle_that_turns_and_a_road_wider_than_any_are_built():
    assert layout_of(crash("Straight", vehicle("W2E", "Turn Left"))).is_junction
    wide = layout_of(crash("Straight", vehicle("W2E"), lanes=20))
    assert lanes_of(wide) == {"forward": 6, "backward": 6}
    assert "20 lanes" in wide.adapted[-1]


def test_a_vehicle_alone_may_go_straight_on_where_its_road_ends():
    what = crash("T-intersection", vehicle("N2S"), stem="North")
    layout = layout_of(what)
    assert layout.ends
    assert layout.adapted == ()
    assert [arm.name for arm in layout.network.arms] == ["east", "north", "west"]
    assert layout.ways[0].route == ("north_in", "west_out")
    assert not layout_of(crash("T-intersection", vehicle("E2W"), stem="North")).ends
    assert not layout_of(crash("T-intersection", vehicle("N2S"), vehicle("E2W"), stem="North")).ends
