"""Accelerations from places: what tyres can do passes, jumps and kinks do not."""

import math

import numpy as np
import pytest

from roadmend.core.tick import INTERVAL
from roadmend.safe.motion import motion_of, motions_of

from .films import film_of


def track(place, ticks=80):
    return np.array([(tick, *place(tick * INTERVAL)) for tick in range(ticks)])


def test_braking_and_turning_are_measured():
    braking = motion_of(track(lambda t: (40.0 * t - 0.5 * 7.0 * t * t, 0.0)))
    assert braking.longitudinal == pytest.approx(7.0, abs=0.01)
    assert braking.lateral == pytest.approx(0.0, abs=0.01)
    assert braking.is_physical
    round_and_round = motion_of(track(lambda t: (20.0 * math.cos(0.4 * t), 20.0 * math.sin(0.4 * t))))
    assert round_and_round.lateral == pytest.approx(20.0 * 0.16, rel=0.02)
    assert round_and_round.is_physical


@pytest.mark.parametrize(
    "place",
    [
        lambda t: (20.0 * t - 0.5 * 11.0 * t * t, 0.0),  # more than 1 g
        lambda t: (20.0 * math.cos(0.6 * t), 20.0 * math.sin(0.6 * t)),  # 7.2 m/s2 in a bend
        lambda t: (10.0 * t + (0.8 if t > 2.0 else 0.0), 0.0),  # a jump
        lambda t: (10.0 * t, 0.7 * max(0.0, t - 2.0) * 10.0),  # a kink
    ],
)
def test_what_no_vehicle_can_do_is_seen(place):
    assert not motion_of(track(place)).is_physical


def test_what_a_thing_does_to_a_vehicle_that_strikes_it_is_left_out():
    film = film_of(("ego", (0.0, 0.0), 0.0, 5.0), ("v1", (30.0, 0.0), 0.0, 15.0), ego="ego", ticks=40)
    last = film.everyone[-1]["v1"]
    film.everyone += [{"v1": last._replace(speed=0.0)}] * 30
    film.ego += [film.ego[-1]] * 30
    assert motions_of(film)["v1"].longitudinal > 20.0
    assert motions_of(film, {"v1": 39})["v1"].longitudinal == pytest.approx(0.0, abs=0.01)
    assert motions_of(film, {"v1": 10})["v1"].longitudinal > 20.0


def test_who_stands_or_is_there_for_a_moment_is_no_case():
    assert motion_of(track(lambda _: (3.0, 4.0))).is_physical
    assert motion_of(track(lambda t: (9.0 * t, 0.0), ticks=3)).is_physical


def test_who_was_away_meanwhile_did_not_jump():
    there = track(lambda t: (10.0 * t, 0.0), ticks=30)
    again = track(lambda t: (300.0 + 10.0 * t, 50.0), ticks=30) + np.array([60, 0.0, 0.0])
    assert motion_of(np.vstack([there, again])).is_physical
