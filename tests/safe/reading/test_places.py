"""Ways that follow from where a place lies, where a bystander looks, where the sun stands, and what is no way at all."""

import pytest

from roadmend.safe.dsl import Action, Position
from roadmend.safe.reading.reader import read_summary

EAST, NORTH, WEST, SOUTH = Position.W2E, Position.S2N, Position.E2W, Position.N2S


def vehicles(text):
    return read_summary(text).scenario.vehicles


@pytest.mark.parametrize(
    ("text", "ways"),
    [
        ("I drove my Civic down to the mill, which is south of us, and slid into a tree.", [SOUTH]),
        ("A Honda Civic came up from the orchard, which is at the south end, and hit a parked van.", [NORTH]),
        ("We were in my Tacoma going toward the library. The library sits at the west end. I hit a pole.", [WEST]),
        ("I was walking east. A Ford Focus came past going the same way I was walking and hit a pole.", [EAST]),
        (
            "We were looking north. A Jeep came from our left and its front hit a Ford Focus coming toward us.",
            [EAST, SOUTH],
        ),
        (
            "At 7 in the morning the sun came in through the right side windows as the Civic went by. It hit a tree.",
            [NORTH],
        ),
        ("V1: Honda Civic DIR: E. V2: Ford Focus DIR: W. V1 hit V2 head on.", [EAST, WEST]),
    ],
)
def test_ways_follow_from_what_lies_where(text, ways):
    assert [each.initial_position for each in vehicles(text)][: len(ways)] == ways


@pytest.mark.parametrize(
    ("text", "way"),
    [
        ("V1 was eastbound in the left lane making a left turn to go nb. V1 hit a pole.", EAST),
        ("V1 was westbound. V1 struck V2 and was found in a field facing south.", WEST),
        ("V1 was traveling northeast on a straight road and hit a tree. V1 came to rest facing south.", None),
    ],
)
def test_where_one_ends_is_not_how_one_came(text, way):
    found = vehicles(text)[0].initial_position
    assert found is way or (way is None and found in {EAST, NORTH, None})


@pytest.mark.parametrize(
    ("text", "action"),
    [
        ("V1 had the stop sign, stopped and started his left. V2 hit its side.", Action.TURN_LEFT),
        ("V1 was going east. The driver did look to the left. V1 hit V2.", Action.MOVE_FORWARD),
        ("V1 was in a curve, turning right for northbound traffic, and hit V2.", Action.MOVE_FORWARD),
        ("V1 hung a little left and was hit by V2.", Action.MOVE_FORWARD),
        ("V1 was going east and couldn't go left because of V2. V1 hit V2.", Action.MOVE_FORWARD),
    ],
)
def test_not_every_hand_is_a_turn(text, action):
    assert vehicles(text)[0].action is action
