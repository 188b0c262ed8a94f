"""Posted limits among the words of a sketch."""

import pytest

from roadmend.safe.claims import Box
from roadmend.safe.sketch.limits import LimitScope, posted_limits
from roadmend.safe.sketch.words import SketchWord


def word(text, left=100, top=100, height=20):
    return SketchWord(text, Box(left, top, left + 9 * len(text), top + height), 0.95)


def read(*texts):
    words = [word(text, top=100 + 60 * index) for index, text in enumerate(texts)]
    return [(limit.mph, limit.scope) for limit in posted_limits(words)]


@pytest.mark.parametrize(
    ("text", "mph"),
    [
        ("Speed Limit 45 mph", 45),
        ("SPEED LIMIT = 64 KM/H (40 MPH)", 40),
        ("Speedlimit70mph", 70),
        ("posted speed limit: 72 kmph / 45 mph", 45),
        ("Speed limit 35 mph / 56 kph", 35),
        ("PSL 30", 30),
        ("Speed Limit: 80 km/h", 50),
        ("Speed Limit 5O mph", 50),
        ("Posted 25 M.P.H.", 25),
        ("35 MPH", 35),
    ],
)
def test_a_limit_in_many_words(text, mph):
    assert read(text) == [(mph, LimitScope.ALL)]


@pytest.mark.parametrize(
    "text",
    [
        "Advisory speed 25 mph",
        "V1 travel speed 45 mph",
        "Speed limit unknown",
        "Scale 1 cm = 35 m",
        "Speed limit 47 mph",  # nobody posts that: misread
        "Speed limit 99 mph",
        "35",
        "Limited access freeway",
    ],
)
def test_what_is_no_limit(text):
    assert read(text) == []


def test_a_limit_for_cars_and_another_for_trucks():
    assert read("Speed limit 70 mph for cars, 55 mph for trucks") == [(70, LimitScope.CARS), (55, LimitScope.TRUCKS)]


def test_a_limit_for_each_road():
    assert read("N/S speed limit 35 mph", "E/W speed limit 45 mph") == [
        (35, LimitScope.NORTH_SOUTH),
        (45, LimitScope.EAST_WEST),
    ]


def test_a_limit_for_one_vehicle():
    (limit,) = posted_limits([word("V2 speed limit 40 mph")])
    assert (limit.mph, limit.scope, limit.vehicle) == (40, LimitScope.VEHICLE, 2)


def test_a_row_of_a_table():
    words = [word("Speed Limit:", left=100), word("40 kmph (25 mph)", left=240), word("Weather:", top=125)]
    assert [limit.mph for limit in posted_limits(words)] == [25]


def test_a_sign_has_its_number_below():
    words = [word("SPEED", top=100), word("LIMIT", top=122), word("35", left=110, top=145)]
    assert [limit.mph for limit in posted_limits(words)] == [35]


def test_what_stands_beside_a_limit_is_not_whom_it_is_for():
    words = [word("Eastbound lanes", left=100), word("Speed limit = 70 mph", left=300)]
    assert [(limit.mph, limit.scope) for limit in posted_limits(words)] == [(70, LimitScope.ALL)]


def test_two_speeds_without_a_word_are_no_limit():
    assert read("35 mph", "50 mph") == []
