"""Every kind of contact, and what its event says."""

import math

import pytest

from roadmend.core.outcome import Blame
from roadmend.core.scene import EgoState, ObjectList
from roadmend.world.blame import find_blame

LENGTH, WIDTH = 4.6, 1.8


def ego(speed, yaw=0.0):
    return EgoState.from_yaw(10.0, 20.0, yaw, speed, 0.0, LENGTH, WIDTH)


def other(along, across, heading, speed, yaw=0.0):
    """Somebody of the ego's size, placed relative to it."""
    cosine, sine = math.cos(yaw), math.sin(yaw)
    x, y = 10.0 + along * cosine - across * sine, 20.0 + along * sine + across * cosine
    return ObjectList.of(
        id=[1],
        kind=0,
        x=x,
        y=y,
        yaw=yaw + heading,
        speed=speed,
        acceleration=0.0,
        yaw_rate=0.0,
        length=LENGTH,
        width=WIDTH,
    )


@pytest.mark.parametrize("yaw", [0.0, 2.0, -3.0])
@pytest.mark.parametrize(
    ("speed", "place", "expected"),
    [
        (0.0, (4.5, 0.0, math.pi, 3.0), Blame.EGO_STOOD),
        (0.04, (-4.5, 0.0, 0.0, 3.0), Blame.EGO_STOOD),
        (5.0, (4.5, 0.0, 0.0, 0.0), Blame.OTHER_STOOD),
        (5.0, (0.0, 1.7, 0.0, 0.0), Blame.OTHER_STOOD),
        (5.0, (4.5, 0.0, 0.0, 3.0), Blame.FRONT),
        (5.0, (3.1, 0.5, 0.5 * math.pi, 3.0), Blame.FRONT),
        (5.0, (-4.5, 0.0, 0.0, 9.0), Blame.REAR),
        (5.0, (-3.1, 0.5, 0.5 * math.pi, 9.0), Blame.REAR),
        (5.0, (0.0, 3.1, -0.5 * math.pi, 9.0), Blame.SIDE),
    ],
)
def test_the_kind_of_a_contact(yaw, speed, place, expected):
    assert find_blame(ego(speed, yaw), other(*place, yaw=yaw), 0, changing=False) is expected


@pytest.mark.parametrize(
    ("place", "expected"),
    [
        ((0.0, 3.1, -0.5 * math.pi, 9.0), Blame.CHANGING),
        ((-4.5, 0.0, 0.0, 9.0), Blame.CHANGING),
        ((4.5, 0.0, 0.0, 3.0), Blame.FRONT),
    ],
)
def test_a_contact_while_changing_lanes(place, expected):
    assert find_blame(ego(5.0), other(*place), 0, changing=True) is expected


def test_the_ego_is_at_fault_for_what_it_hits_and_while_it_changes_lanes():
    assert [blame for blame in Blame if blame.is_egos] == [Blame.OTHER_STOOD, Blame.FRONT, Blame.CHANGING]
