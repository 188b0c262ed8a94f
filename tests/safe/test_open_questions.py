"""What a report leaves open is drawn; what it says is kept."""

import random

import pytest

from roadmend.safe.open_questions import answer, open_questions
from roadmend.world.space import sample

from .crashes import ALL, crash, vehicle


@pytest.mark.parametrize("name", ALL)
def test_answers_fill_every_null_field_and_change_no_other(name):
    what = ALL[name]
    for seed in range(20):
        full = answer(what, sample(open_questions(what), random.Random(seed)))
        for before, after in zip(what.vehicles, full.vehicles, strict=True):
            for field in ("model", "initial_position", "action", "speed_limit_mph"):
                said, filled = getattr(before, field), getattr(after, field)
                assert filled is not None
                assert said in (None, filled)
        assert full.road.lanes == (what.road.lanes or full.road.lanes) is not None
        assert None not in (full.environment.time, full.environment.weather)
        assert (full.road.stem is None) == (full.road.road_type != "T-intersection")


@pytest.mark.parametrize(
    ("vehicles", "types"),
    [
        ((vehicle("W2E"), vehicle("E2W")), {"Straight", "Curve"}),
        ((vehicle("W2E"), vehicle("S2N")), {"Intersection", "T-intersection"}),
        ((vehicle("W2E", "Turn Left"), vehicle("E2W")), {"Intersection", "T-intersection"}),
    ],
)
def test_an_open_road_type_goes_with_the_vehicles(vehicles, types):
    assert {*open_questions(crash(None, *vehicles))["road_type"].weights} == types


@pytest.mark.parametrize("turn", ["Turn Left", "Turn Right"])
def test_a_turn_that_the_manoeuvre_tells_is_no_open_question(turn):
    what = crash(None, vehicle("W2E", None, turn), vehicle("E2W"))
    space = open_questions(what)
    assert "v1.action" not in space
    assert {*space["road_type"].weights} == {"Intersection", "T-intersection"}
    assert answer(what, sample(space, random.Random(1))).vehicles[0].action == turn


def test_an_open_speed_limit_is_another_vehicles_where_one_is_known():
    space = open_questions(crash("Straight", vehicle(limit=None), vehicle("E2W", limit=50)))
    assert [*space["v1.speed_limit"].weights] == [50]
    alone = open_questions(crash("Straight", vehicle(limit=None)))
    assert [*alone["v1.speed_limit"].weights] == [35, 45, 55]


def test_who_comes_from_nowhere_on_a_straight_road_comes_along_it():
    space = open_questions(crash("Straight", vehicle("N2S"), vehicle(None)))
    assert {*space["v2.position"].weights} == {"N2S", "S2N"}
