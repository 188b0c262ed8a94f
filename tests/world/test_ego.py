"""The ego's body behaves like a car."""

import math

import numpy as np
import pytest

from roadmend.core.command import Command
from roadmend.core.route import Route, Stage, Window
from roadmend.world.ego import LongitudinalDynamics, RouteFollower, VehicleParameters

DT = 0.05
FULL_BRAKE, FULL_THROTTLE, COAST = Command(0.0, 1.0), Command(1.0, 0.0), Command(0.0, 0.0)


def car(speed=0.0, friction=0.9):
    return LongitudinalDynamics(VehicleParameters(), friction, speed)


def stopping_distance(speed, friction):
    body, distance = car(speed, friction), 0.0
    for _ in range(1000):
        distance += body.step(FULL_BRAKE, DT, 0.0)
        if body.speed == 0.0:
            return distance
    pytest.fail("never stopped")


def test_full_brake_from_50_kmh_stops_in_about_14_m_on_a_dry_road():
    assert 12.5 < stopping_distance(13.89, 0.9) < 15.5


def test_a_slippery_road_makes_braking_longer():
    assert stopping_distance(13.89, 0.35) > 2.0 * stopping_distance(13.89, 0.9)


def test_full_throttle_reaches_100_kmh_in_about_ten_seconds():
    body = car()
    seconds = next(tick * DT for tick in range(2000) if body.step(FULL_THROTTLE, DT, 0.0) >= 0 and body.speed > 27.78)
    assert 8.0 < seconds < 14.0


def test_it_coasts_down_and_never_rolls_backwards():
    body = car(3.0)
    for _ in range(2000):
        assert body.step(COAST, DT, 0.0) >= 0.0
    assert body.speed == 0.0


def test_the_brake_answers_with_a_lag():
    body = car(20.0)
    body.step(FULL_BRAKE, DT, 0.0)
    first = body.acceleration
    for _ in range(10):
        body.step(FULL_BRAKE, DT, 0.0)
    assert -4.0 < first < -1.0
    assert body.acceleration < -7.0


def test_less_grip_is_left_for_braking_in_a_curve():
    straight, curve = car(15.0), car(15.0)
    for _ in range(10):
        straight.step(FULL_BRAKE, DT, 0.0)
        curve.step(FULL_BRAKE, DT, 1.0 / 30.0)
    assert curve.speed > straight.speed + 0.2


def two_lanes():
    x = np.linspace(0.0, 300.0, 31)
    stages = tuple(Stage(x, np.full_like(x, y), np.full_like(x, 20.0)) for y in (0.0, 3.2))
    return Route("t", 4.7, 1.85, 290.0, 60.0, stages, (Window(50.0, 150.0),), ())


def test_a_lane_change_begins_only_inside_its_window():
    follower = RouteFollower(two_lanes(), 40.0)
    assert not follower.begin_change(15.0)
    follower.advance(20.0)
    assert follower.begin_change(15.0)
    assert not follower.begin_change(15.0)


def test_a_lane_change_is_smooth_and_ends_on_the_next_lane():
    follower = RouteFollower(two_lanes(), 60.0)
    follower.begin_change(15.0)
    before, step, turned = (follower.x, follower.y, follower.yaw), 15.0 * DT, 0.0
    while follower.changing:
        follower.advance(step)
        moved = math.hypot(follower.x - before[0], follower.y - before[1])
        assert moved == pytest.approx(step, rel=0.05)
        turned = max(turned, abs(follower.yaw - before[2]))
        before = (follower.x, follower.y, follower.yaw)
    assert follower.stage == 1
    assert follower.y == pytest.approx(3.2)
    assert follower.yaw == pytest.approx(0.0, abs=0.02)
    assert turned < 0.02  # [rad] a tick: no jerk of the wheel


def test_driving_past_the_end_of_a_lane_is_off_route():
    follower = RouteFollower(two_lanes(), 290.0)
    follower.advance(12.0)
    assert follower.off_route
    assert not follower.at_goal
