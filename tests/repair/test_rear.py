"""Who closes in from behind: times by hand, and who does not count."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from roadmend.repair.adreft.rear import time_to_rear

from .playground import Box, ego_at, scene_of


@pytest.mark.parametrize(
    ("box", "time"),
    [
        (Box(1, -25.0, 0.0, speed=15.0), (25.0 - 4.5 - 1.0) / 5.0),  # bumper to bumper less a metre, 5 m/s faster
        (Box(1, -25.0, 0.0, speed=10.0), math.inf),  # keeps its distance
        (Box(1, -5.0, 0.0, speed=2.0), 0.0),  # so near that its speed does not matter
        (Box(1, 25.0, 0.0, speed=0.0), math.inf),  # ahead
        (Box(1, -25.0, 3.5, speed=15.0), math.inf),  # on the next lane
        (Box(1, -25.0, 0.0, yaw=math.pi, speed=15.0), math.inf),  # drives away
        (Box(1, 0.0, -25.0, yaw=math.pi / 2.0, speed=15.0), math.inf),  # crosses
    ],
)
def test_times_by_hand(box, time):
    assert time_to_rear(scene_of([box], ego=ego_at(speed=10.0))) == pytest.approx(time)


def test_the_first_of_several_counts_and_nobody_is_never():
    assert time_to_rear(scene_of([], ego=ego_at(speed=10.0))) == math.inf
    both = [Box(1, -25.0, 0.0, speed=15.0), Box(2, -15.0, 0.0, speed=20.0)]
    assert time_to_rear(scene_of(both, ego=ego_at(speed=10.0))) == pytest.approx(0.95)


def test_one_who_turns_is_followed_around_the_bend():
    # A quarter of a circle of radius 20 m behind: where the ego is, it drives as the ego does.
    box = Box(1, -20.0, -20.0, yaw=math.pi / 2.0, speed=10.0, yaw_rate=-0.5)
    assert time_to_rear(scene_of([box], ego=ego_at(speed=5.0))) == pytest.approx((20.0 * math.pi / 2.0 - 5.5) / 5.0)


@given(st.floats(0.0, 40.0), st.floats(0.0, 40.0), st.floats(-60.0, 60.0), st.floats(-10.0, 10.0))
def test_who_closes_in_faster_is_there_no_later(ego, other, x, y):
    def time(speed):
        return time_to_rear(scene_of([Box(1, x, y, speed=speed)], ego=ego_at(speed=ego)))

    assert time(other + 1.0) <= time(other)
