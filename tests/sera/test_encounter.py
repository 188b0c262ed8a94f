"""Every kind of encounter on a road toward the east, the ego at the origin."""

import math

import numpy as np
import pytest

from roadmend.core.scene import ObjectKind
from roadmend.sera.encounter import Met, braking_of, classify, hazard_of

from .recorded import LANE, ego, track

T = np.linspace(0.0, 4.0, 81)
EAST, NORTH, WEST, SOUTH = 0.0, 0.5 * math.pi, math.pi, -0.5 * math.pi


def met(way, changing=False, heading=0.0, own=None):
    return classify(way, own or ego(), heading, LANE, 140.0, changing=changing)


@pytest.mark.parametrize(
    ("way", "expected"),
    [
        (track(40.0, 30.0 - 8.0 * T, SOUTH, 8.0), Met("crossing_from_left", "left")),
        (track(40.0, -30.0 + 8.0 * T, NORTH, 8.0), Met("crossing_from_right", "right")),
        (track(80.0 - 10.0 * T, 3.2, WEST, 10.0), Met("oncoming", "oncoming")),
        (track(80.0 - 8.0 * T, 3.2 - T, WEST + 0.3 * T, 8.0), Met("oncoming_turn", "oncoming")),
        (track(15.0 + 9.0 * T, 3.2 - 0.8 * T, EAST, 9.0), Met("cut_in", "left")),
        (track(15.0 + 9.0 * T, -3.2 + 0.5 * T, EAST, 9.0), Met("cut_in", "right")),
        (track(2.0 + 10.0 * T, 3.2, EAST, 10.0), Met("alongside", "left")),
        (track(20.0 + 9.0 * T, 0.2, EAST, 9.0), Met("slow_leader", "ahead")),
        (track(20.0 + 9.0 * T, 0.2, EAST, 9.0, acceleration=-3.5), Met("braking_leader", "ahead")),
        (track(40.0, 0.2, EAST, 0.0 * T), Met("standing_leader", "ahead")),
        (track(-20.0 + 14.0 * T, -0.2, EAST, 14.0), Met("follower", "behind")),
        (track(40.0, 6.0 - 1.4 * T, SOUTH, 1.4, ObjectKind.PEDESTRIAN), Met("pedestrian", "left")),
        (track(40.0, -6.0 + 1.4 * T, NORTH, 1.4, ObjectKind.PEDESTRIAN), Met("pedestrian", "right")),
    ],
)
def test_the_way_of_the_other_tells_the_kind(way, expected):
    assert met(way) == expected


def test_who_drives_in_the_lane_that_the_ego_changes_to_is_told_from_one_that_cuts_in():
    beside = track(5.0 + 10.0 * T, 0.0, EAST, 10.0)
    assert met(beside, changing=True, own=ego(y=3.2)) == Met("in_target_lane", "right")
    assert met(beside, changing=True, own=ego(y=-3.2)) == Met("in_target_lane", "left")
    assert met(track(20.0 + 9.0 * T, 3.2, EAST, 9.0), changing=True, own=ego(y=3.2)) == Met("slow_leader", "ahead")


def test_a_turning_ego_judges_by_where_it_came_from():
    other = track(40.0, 30.0 - 8.0 * T, SOUTH, 8.0)
    assert met(other, own=ego(yaw=-1.2), heading=0.0) == Met("crossing_from_left", "left")


@pytest.mark.parametrize(
    ("encounter", "rule", "braking", "hazard"),
    [
        ("pedestrian", None, 0.0, "pedestrian_crossing"),
        ("cut_in", None, 0.0, "cut_in"),
        ("cut_in", None, 5.0, "cut_in_and_brake"),
        ("braking_leader", None, 5.0, "hard_braking"),
        ("crossing_from_left", "priority", 0.0, "run_right_of_way"),
        ("oncoming_turn", "priority", 0.0, "run_right_of_way"),
        ("crossing_from_left", "yield", 0.0, None),
        ("crossing_from_right", "signal", 0.0, None),
        ("slow_leader", None, 0.0, None),
    ],
)
def test_a_hazard_is_what_the_other_does_wrong(encounter, rule, braking, hazard):
    way = track(0.0, 0.0, 0.0, T, acceleration=-braking)
    assert braking_of(way) == braking
    assert hazard_of(Met(encounter, "left"), way, rule) == hazard
