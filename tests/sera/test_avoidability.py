"""The last moment at which braking would have helped, against what physics says."""

import math

import numpy as np
import pytest

from roadmend.sera.avoidability import LOOK_BACK, last_avoidable

from .recorded import TICK_NS, ego, track


def approach(speed, ticks=200, end=0.0):
    """The ego toward the east at a constant speed, at ``end`` [m] with the last tick."""
    return [ego(end - speed * (ticks - 1 - number) / 20, speed=speed) for number in range(ticks)]


def stamps(egos):
    return [number * TICK_NS for number in range(len(egos))]


@pytest.mark.parametrize("speed", [6.0, 12.0, 20.0])
def test_for_a_standing_obstacle_it_is_the_braking_distance(speed):
    egos = approach(speed)
    wall = track(4.0, 0.0, 0.0, np.zeros(200))  # both are 4 m long: contact with the last tick
    found = last_avoidable(stamps(egos), egos, wall, 0.9)
    assert found == pytest.approx(0.5 * speed / 8.0 + 0.12, abs=0.12)  # v / 2a, and the lag of the brake


def test_on_snow_it_is_earlier():
    egos = approach(12.0)
    wall = track(4.0, 0.0, 0.0, np.zeros(200))
    dry, snow = (last_avoidable(stamps(egos), egos, wall, friction) for friction in (0.9, 0.35))
    assert snow > 1.8 * dry


def test_a_crossing_participant_is_let_through_by_less_braking_than_a_stop():
    egos = approach(12.0)
    ticks = np.arange(200)
    crossing = track(3.0, -10.0 * (199 - ticks) / 20, 0.5 * math.pi, 10.0)
    wall = track(4.0, 0.0, 0.0, np.zeros(200))
    assert 0.05 <= last_avoidable(stamps(egos), egos, crossing, 0.9) < last_avoidable(stamps(egos), egos, wall, 0.9)


def test_who_runs_into_the_ego_from_behind_cannot_be_avoided_by_braking():
    egos = approach(5.0)
    chaser = track(-4.0 - 7.0 * (199 - np.arange(200)) / 20, 0.0, 0.0, 12.0)
    assert last_avoidable(stamps(egos), egos, chaser, 0.9) is None


def test_nothing_is_said_about_more_than_the_last_seconds():
    egos = approach(40.0, ticks=400)
    wall = track(4.0, 0.0, 0.0, np.zeros(400))
    assert last_avoidable(stamps(egos), egos, wall, 0.1) is None  # it takes more than 40 s on such ice
    assert LOOK_BACK < 20.0


def test_an_episode_of_one_tick_leaves_no_time():
    assert last_avoidable([0], [ego()], track(4.0, 0.0, 0.0, [0.0]), 0.9) is None
