"""Every kind of contact, and what its event says."""

import math

import numpy as np
import pytest

from roadmend.core.outcome import Blame
from roadmend.core.scene import EgoState, ObjectList
from roadmend.world.blame import find_blame

LENGTH, WIDTH = 4.6, 1.8


def ego(speed, yaw=0.0):
    return EgoState.from_yaw(10.0, 20.0, yaw, speed, 0.0, LENGTH, WIDTH)


def others(*places, yaw=0.0):
    """Those of the ego's size who are there, each placed relative to it: along, across, heading, speed."""
    along, across, heading, speed = np.array(places, dtype=float).T
    cosine, sine = math.cos(yaw), math.sin(yaw)
    x, y = 10.0 + along * cosine - across * sine, 20.0 + along * sine + across * cosine
    return ObjectList.of(
        id=np.arange(1, len(places) + 1),
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
    assert find_blame(ego(speed, yaw), others(place, yaw=yaw), 0, changing=False) is expected


@pytest.mark.parametrize(
    ("place", "expected"),
    [
        ((0.0, 3.1, -0.5 * math.pi, 9.0), Blame.CHANGING),
        ((-4.5, 0.0, 0.0, 9.0), Blame.CHANGING),
        ((4.5, 0.0, 0.0, 3.0), Blame.FRONT),
    ],
)
def test_a_contact_while_changing_lanes(place, expected):
    assert find_blame(ego(5.0), others(place), 0, changing=True) is expected


@pytest.mark.parametrize("yaw", [0.0, 2.0, -3.0])
@pytest.mark.parametrize(
    ("end", "expected"),
    [
        (0.5 * LENGTH - 0.0205, Blame.SIDE),
        (0.5 * LENGTH - 0.0195, Blame.FRONT),
        (0.5 * LENGTH + 0.3, Blame.FRONT),
        (-0.5 * LENGTH + 0.0205, Blame.SIDE),
        (-0.5 * LENGTH + 0.0195, Blame.REAR),
        (-0.5 * LENGTH - 0.3, Blame.REAR),
    ],
)
def test_the_bumpers_are_2_cm_deep(end, expected, yaw):
    """Somebody drives at the ego's side and reaches along it up to ``end``."""
    middle = end - math.copysign(0.5 * WIDTH, end)
    contact = others((middle, 0.5 * (WIDTH + LENGTH) - 0.1, -0.5 * math.pi, 5.0), yaw=yaw)
    assert find_blame(ego(5.0, yaw), contact, 0, changing=False) is expected


@pytest.mark.parametrize(("speed", "stands"), [(0.0, True), (0.0499, True), (0.05, False), (0.0501, False)])
def test_who_is_slower_than_5_cm_per_second_stands(speed, stands):
    ahead = (4.5, 0.0, 0.0)
    kind = find_blame(ego(speed), others((*ahead, 3.0)), 0, changing=False)
    assert kind is (Blame.EGO_STOOD if stands else Blame.FRONT)
    kind = find_blame(ego(5.0), others((*ahead, speed)), 0, changing=False)
    assert kind is (Blame.OTHER_STOOD if stands else Blame.FRONT)


def test_where_both_stand_it_is_not_the_egos_fault():
    assert find_blame(ego(0.0), others((4.5, 0.0, 0.0, 0.0)), 0, changing=True) is Blame.EGO_STOOD


def test_of_several_around_only_the_one_that_it_met_counts():
    around = others((30.0, 0.0, 0.0, 0.0), (-4.5, 0.0, 0.0, 9.0), (4.5, 0.0, 0.0, 3.0))
    assert find_blame(ego(5.0), around, 1, changing=False) is Blame.REAR
    assert find_blame(ego(5.0), around, 2, changing=False) is Blame.FRONT


def test_the_ego_is_at_fault_for_what_it_hits_and_while_it_changes_lanes():
    assert [blame for blame in Blame if blame.is_egos] == [Blame.OTHER_STOOD, Blame.FRONT, Blame.CHANGING]
