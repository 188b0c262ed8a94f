"""Where the ego is and what it does, in the words of traffic."""

import math
from dataclasses import replace

import numpy as np
import pytest

from roadmend.core.outcome import Event, EventKind
from roadmend.core.route import Stage
from roadmend.measures.route_progress import RoutePlace
from roadmend.sera.describe import describe
from roadmend.sera.incident import IncidentPlace
from roadmend.sera.place import action_of, is_changing, place_of
from roadmend.world.families import sample_scenario

from .recorded import CROSSING, JUNCTION, ego, route


@pytest.mark.parametrize(
    ("position", "kind", "distance"),
    [
        (100.0, "lane", None),
        (141.0, "at_crossing", -3.0),
        (160.0, "before_junction", 28.0),
        (187.9, "before_junction", 0.1),
        (188.0, "in_junction", 0.0),
        (212.0, "in_junction", -24.0),
        (212.1, "after_junction", -24.1),
        (242.0, "after_junction", -54.0),
        (243.0, "lane", None),
    ],
)
def test_the_outline_decides_what_is_in_before_and_behind_a_junction(position, kind, distance):
    found = place_of(route(CROSSING, JUNCTION), RoutePlace(0, position, 0.0), None)
    assert found.kind == kind
    assert found.distance == (None if distance is None else pytest.approx(distance))
    assert found.right_of_way == {"lane": None, "at_crossing": "crossing"}.get(kind, "yield")


def test_zones_of_another_lane_do_not_count():
    assert place_of(route(replace(JUNCTION, stage=1)), RoutePlace(0, 200.0, 0.0), None).kind == "lane"


def highway(family):
    for seed in range(20):
        descriptor = describe(sample_scenario(family, seed))
        if descriptor.manoeuvre in {"exit", "merge"}:
            return descriptor
    raise AssertionError(family)


def test_on_highways_lanes_have_names():
    drawn = route(JUNCTION)
    two = replace(drawn, stages=drawn.stages * 2, windows=(), zones=())
    assert place_of(two, RoutePlace(0, 200.0, 0.0), highway("S4")).kind == "highway"
    assert place_of(two, RoutePlace(1, 200.0, 0.0), highway("S4")) == IncidentPlace("exit_lane", 1)


@pytest.mark.parametrize(
    ("bend", "action"), [(0.5, "turning_left"), (-0.5, "turning_right"), (0.0, "crossing_straight")]
)
def test_a_turn_is_told_by_the_way_through_the_junction(bend, action):
    angle = bend * math.pi
    x = np.array([-100.0, 95.0, 105.0, 105.0 + 100.0 * math.cos(angle)])
    drawn = route(JUNCTION, stage=Stage(x, np.array([0.0, 0.0, 0.0, 100.0 * math.sin(angle)]), np.full(4, 14.0)))
    at = RoutePlace(0, 200.0, 0.0)
    where = place_of(drawn, at, None)
    assert action_of(drawn, at, ego(100.0), where, changing=False) == action
    assert action_of(drawn, at, ego(100.0, speed=0.01), where, changing=True) == "standing"
    assert action_of(drawn, at, ego(100.0), where, changing=True) == "changing_lane"


def test_away_from_junctions_it_drives_on():
    at = RoutePlace(0, 50.0, 0.0)
    assert action_of(route(JUNCTION), at, ego(), place_of(route(JUNCTION), at, None), changing=False) == "driving_on"


def test_a_lane_change_lasts_as_far_as_the_ego_needs_for_it():
    begun = [Event(1.0, EventKind.CHANGE_LANE, "to stage 1")]
    egos = [(0.1 * number, ego(number * 1.0)) for number in range(60)]  # 30 m at 10 m/s
    assert not is_changing(begun, egos[:10])
    assert is_changing(begun, egos[:11])
    assert is_changing(begun, egos[:40])
    assert not is_changing(begun, egos[:41])
    assert not is_changing([], egos)


def test_where_a_crossing_lies_in_a_junction_the_other_decides_which_it_is_about():
    drawn = route(replace(CROSSING, begin=205.0, end=209.0), JUNCTION)
    at = RoutePlace(0, 206.0, 0.0)
    assert place_of(drawn, at, None).kind == "in_junction"
    assert place_of(drawn, at, None, on_foot=True).kind == "at_crossing"
