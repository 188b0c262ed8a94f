"""The ego's body behaves like a car: every force and every turn against its formula."""

import math

import numpy as np
import pytest

from roadmend.core.command import Command
from roadmend.core.route import Route, Stage, Window
from roadmend.world.ego import STANDING, LongitudinalDynamics, RouteFollower, VehicleParameters

DT = 0.05  # [s]
FULL_BRAKE, FULL_THROTTLE, COAST = Command(0.0, 1.0), Command(1.0, 0.0), Command(0.0, 0.0)
SPEEDS = [0.5, 5.0, 13.9, 30.0]  # [m/s]
G = 9.81  # [m/s2]


def car(speed=0.0, friction=0.9, **parameters):
    return LongitudinalDynamics(VehicleParameters(**parameters), friction, speed)


def resistance(speed):
    """Of the air, 0.243 m/s2 at 30 m/s, and of the tyres [m/s2]."""
    return 0.243 * (speed / 30.0) ** 2 + 0.12


def settled(command, speed, friction=0.9, curvature=0.0):
    """Acceleration at a speed once the pedal's lag is over [m/s2]."""
    body = car(speed, friction)
    for _ in range(200):
        body.speed = speed
        body.step(command, DT, curvature)
    return body.acceleration


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


@pytest.mark.parametrize("speed", SPEEDS)
def test_a_coasting_car_is_slowed_by_air_and_tyres(speed):
    body = car(speed)
    assert body.acceleration == 0.0
    body.step(COAST, DT, 0.0)
    assert body.acceleration == pytest.approx(-resistance(speed), rel=1e-9)
    assert body.speed == pytest.approx(speed - resistance(speed) * DT, rel=1e-12)


def test_a_standing_car_stays_where_it_is():
    body = car(0.0)
    assert [body.step(command, DT, 0.0) for command in (COAST, FULL_BRAKE)] == [0.0, 0.0]
    assert (body.speed, body.acceleration) == (0.0, 0.0)


@pytest.mark.parametrize("interval", [0.05, 0.1])
@pytest.mark.parametrize("ticks", [1, 2, 5])
def test_the_brake_comes_with_a_lag_of_120_ms(ticks, interval):
    body = car(30.0, friction=2.0)
    for _ in range(ticks):
        before = body.speed
        body.step(FULL_BRAKE, interval, 0.0)
    pressed = 1.0 - math.exp(-ticks * interval / 0.12)
    assert body.acceleration == pytest.approx(-8.0 * pressed - resistance(before), rel=1e-9)


@pytest.mark.parametrize("interval", [0.05, 0.1])
@pytest.mark.parametrize("ticks", [1, 2, 5])
def test_the_engine_comes_with_a_lag_of_250_ms(ticks, interval):
    body = car(0.0)
    for _ in range(ticks):
        before = body.speed
        body.step(FULL_THROTTLE, interval, 0.0)
    pressed = 1.0 - math.exp(-ticks * interval / 0.25)
    assert body.acceleration == pytest.approx(3.5 * pressed - resistance(before), rel=1e-9)


def test_while_the_foot_changes_over_both_forces_act():
    body = car(10.0)
    for _ in range(200):
        body.speed = 10.0
        body.step(FULL_THROTTLE, DT, 0.0)
    body.speed = 10.0
    body.step(FULL_BRAKE, DT, 0.0)
    engine, brake = 3.5 * math.exp(-DT / 0.25), 8.0 * (1.0 - math.exp(-DT / 0.12))
    assert body.acceleration == pytest.approx(engine - brake - resistance(10.0), rel=1e-9)


@pytest.mark.parametrize("throttle", [0.2, 0.6, 1.0])
def test_the_engine_pulls_with_35_dm_and_from_17_ms_on_with_60_w_per_kg(throttle):
    for speed in (2.0, 10.0, 17.0):
        assert settled(Command(throttle, 0.0), speed) == pytest.approx(3.5 * throttle - resistance(speed), rel=1e-9)
    for speed in (17.5, 24.0, 30.0):
        expected = 60.0 / speed * throttle - resistance(speed)
        assert settled(Command(throttle, 0.0), speed) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(("speed", "pull"), [(0.0, 2.0), (0.5, 2.0), (1.0, 2.0), (1.02, 2.0 / 1.02), (2.0, 1.0)])
def test_a_weak_engine_pulls_at_a_crawl_as_at_1_ms(speed, pull):
    body = car(speed, power_per_mass=2.0, throttle_lag=1e-3)
    body.step(FULL_THROTTLE, DT, 0.0)
    assert body.acceleration == pytest.approx(pull - resistance(speed), rel=1e-9)


@pytest.mark.parametrize(("pull", "gain"), [(0.06, 0.06), (0.12, 0.12), (0.18, 0.06)])
def test_rolling_resistance_does_not_hold_a_standing_car_against_a_weak_pull(pull, gain):
    """Not as on a road, but what all figures so far were driven with."""
    body = car(0.0, acceleration_max=pull, throttle_lag=1e-3)
    body.step(FULL_THROTTLE, DT, 0.0)
    assert body.acceleration == pytest.approx(gain, rel=1e-9)


@pytest.mark.parametrize("friction", [0.1, 0.3, 0.5, 0.8])
def test_the_tyres_transmit_no_more_than_friction_times_gravity(friction):
    braking = min(8.0, friction * G)
    pulling = min(3.5, friction * G)
    assert settled(FULL_BRAKE, 10.0, friction) == pytest.approx(-braking - resistance(10.0), rel=1e-9)
    assert settled(FULL_THROTTLE, 10.0, friction) == pytest.approx(pulling - resistance(10.0), rel=1e-9)


@pytest.mark.parametrize("share", [0.0, 0.3, 0.6, 0.9, 0.975])
@pytest.mark.parametrize("speed", [5.0, 15.0])
def test_what_a_curve_takes_is_not_left_for_braking(share, speed):
    """The friction circle: (along)^2 + (across)^2 = (friction g)^2."""
    grip = 0.5 * G
    along = grip * math.sin(math.acos(share))
    found = settled(FULL_BRAKE, speed, 0.5, curvature=share * grip / speed**2)
    assert found == pytest.approx(-along - resistance(speed), rel=1e-9)


@pytest.mark.parametrize("share", [0.985, 1.0, 3.0])
def test_a_fifth_of_the_grip_is_always_left(share):
    found = settled(FULL_BRAKE, 10.0, 0.5, curvature=share * 0.5 * G / 10.0**2)
    assert found == pytest.approx(-0.2 * 0.5 * G - resistance(10.0), rel=1e-9)


@pytest.mark.parametrize("command", [COAST, FULL_BRAKE, FULL_THROTTLE])
@pytest.mark.parametrize("speed", SPEEDS)
def test_the_way_of_a_tick_is_that_of_the_mean_speed(command, speed):
    body = car(speed)
    for _ in range(5):
        before = body.speed
        way = body.step(command, DT, 0.0)
        assert way == pytest.approx(0.5 * (before + body.speed) * DT, rel=1e-12)
        assert body.speed - before == pytest.approx(body.acceleration * DT, rel=1e-9, abs=1e-15)


@pytest.mark.parametrize("speed", [5.0, 30.0])  # where the tractive limit, and where the power is what holds
def test_engine_and_brake_can_be_stronger_or_weaker_from_now_on(speed):
    own, scaled = (LongitudinalDynamics(VehicleParameters(), 0.9, speed) for _ in range(2))
    scaled.scale(1.25, 0.75)
    by_hand = VehicleParameters(acceleration_max=4.375, power_per_mass=75.0, brake_max=6.0)
    expected = LongitudinalDynamics(by_hand, 0.9, speed)
    for command in (Command(0.8, 0.0), Command(0.0, 0.7)):
        for dynamics in (own, scaled, expected):
            for _ in range(10):
                dynamics.step(command, 0.05, 0.0)
        assert scaled.speed == expected.speed
        assert abs(scaled.speed - own.speed) > 0.05


def test_who_is_slower_than_5_cm_per_second_stands():
    assert STANDING == 0.05


def placed(angle, along, across):
    """Points of a straight way in the map's frame."""
    along, across = np.broadcast_arrays(np.asarray(along, dtype=float), across)
    cosine, sine = math.cos(angle), math.sin(angle)
    return 30.0 + along * cosine - across * sine, -20.0 + along * sine + across * cosine


def stage_of(x, y):
    return Stage(np.asarray(x), np.asarray(y), np.full(len(x), 20.0))


def two_lanes(angle=0.0, apart=3.2, ahead=20.0):
    """Parallel lanes of 300 m; the second begins ``ahead`` metres before the first, so that arc lengths differ."""
    along = np.linspace(0.0, 300.0, 31)
    stages = (stage_of(*placed(angle, along, 0.0)), stage_of(*placed(angle, along - ahead, apart)))
    return Route("t", 4.7, 1.85, 290.0, 60.0, stages, (Window(50.0, 150.0),), ())


def circle(radius, segment, side=1.0):
    """A polygon around a point whose corners are ``segment`` metres apart."""
    turn = 2.0 * math.asin(0.5 * segment / radius)
    angles = turn * np.arange(int(2.0 * math.pi / turn))
    stage = stage_of(radius * np.sin(angles), side * radius * (1.0 - np.cos(angles)))
    return Route("o", 4.7, 1.85, stage.length, 60.0, (stage,), (), ()), turn


def test_it_starts_on_the_route():
    follower = RouteFollower(two_lanes(0.4), 40.0)
    assert (follower.x, follower.y) == pytest.approx(tuple(map(float, placed(0.4, 40.0, 0.0))))
    assert follower.yaw == pytest.approx(0.4)
    assert (follower.stage, follower.position, follower.curvature) == (0, 40.0, 0.0)
    assert not follower.changing


@pytest.mark.parametrize("angle", [-2.0, 0.0, 3.0])
def test_it_moves_along_its_lane(angle):
    follower = RouteFollower(two_lanes(angle), 40.0)
    for _ in range(10):
        follower.advance(0.7)
    assert (follower.x, follower.y) == pytest.approx(tuple(map(float, placed(angle, 47.0, 0.0))))
    assert follower.position == pytest.approx(47.0)
    assert follower.yaw == pytest.approx(angle)
    assert follower.curvature == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(("position", "begins"), [(49.9, False), (50.0, True), (150.0, True), (150.1, False)])
def test_a_lane_change_begins_only_inside_its_window(position, begins):
    follower = RouteFollower(two_lanes(), position)
    assert follower.begin_change(15.0) is begins
    assert follower.changing is begins
    assert not follower.begin_change(15.0)


def test_there_is_no_lane_change_beyond_the_last_lane():
    follower = RouteFollower(two_lanes(), 60.0)
    follower.begin_change(1.0)
    for _ in range(14):
        follower.advance(1.0)
    assert (follower.stage, follower.changing) == (1, False)
    assert not follower.begin_change(1.0)


@pytest.mark.parametrize(("speed", "length"), [(15.0, 45.0), (5.0, 15.0), (2.0, 12.0), (0.0, 12.0)])
def test_a_lane_change_takes_three_seconds_or_12_m(speed, length):
    follower = RouteFollower(two_lanes(), 60.0)
    follower.begin_change(speed)
    follower.advance(length - 0.1)
    assert (follower.stage, follower.changing) == (0, True)
    follower.advance(0.2)
    assert (follower.stage, follower.changing) == (1, False)
    assert follower.position == pytest.approx(60.0 + length + 0.1 + 20.0)


@pytest.mark.parametrize("start", [50.0, 60.0, 150.0])
@pytest.mark.parametrize("apart", [3.2, -3.2, 0.8])
@pytest.mark.parametrize("angle", [0.0, 1.2, 2.1, -2.5, 3.1, -3.1])
def test_in_a_lane_change_the_offset_is_the_quintic_and_the_nose_points_along_the_way(angle, apart, start):
    follower = RouteFollower(two_lanes(angle, apart), start)
    follower.begin_change(15.0)
    for progress in np.arange(0.1, 1.0, 0.1):
        follower.advance(start + 45.0 * progress - follower.position)
        across = apart * (10.0 * progress**3 - 15.0 * progress**4 + 6.0 * progress**5)
        assert (follower.x, follower.y) == pytest.approx(
            tuple(map(float, placed(angle, start + 45.0 * progress, across))), abs=1e-9
        )
        slope = apart / 45.0 * 30.0 * progress**2 * (1.0 - progress) ** 2  # the quintic's derivative
        assert -math.pi < follower.yaw <= math.pi
        assert math.remainder(follower.yaw - angle, 2.0 * math.pi) == pytest.approx(math.atan(slope), abs=1e-9)


@pytest.mark.parametrize("apart", [3.2, -3.2])
@pytest.mark.parametrize("angle", [0.3, -2.5])
def test_a_lane_change_ends_on_the_next_lane_and_along_it_however_far_the_last_tick_goes(angle, apart):
    follower = RouteFollower(two_lanes(angle, apart), 60.0)
    follower.begin_change(15.0)
    follower.advance(43.0)
    follower.advance(4.0)
    assert (follower.x, follower.y) == pytest.approx(tuple(map(float, placed(angle, 107.0, apart))), abs=1e-9)
    assert follower.yaw == pytest.approx(angle, abs=1e-9)
    follower.advance(1.0)
    assert (follower.x, follower.y) == pytest.approx(tuple(map(float, placed(angle, 108.0, apart))), abs=1e-9)


@pytest.mark.parametrize("opening", [0.1, -0.1])
@pytest.mark.parametrize("angle", [0.3, 3.1, -3.1])
def test_between_lanes_that_part_the_heading_turns_with_the_share_that_is_done(angle, opening):
    first = stage_of(*placed(angle, np.linspace(0.0, 300.0, 31), 0.0))
    along, across = np.linspace(0.0, 300.0, 31) * math.cos(opening), np.linspace(0.0, 300.0, 31) * math.sin(opening)
    second = stage_of(*placed(angle, along, across))
    follower = RouteFollower(Route("t", 4.7, 1.85, 290.0, 60.0, (first, second), (Window(0.0, 300.0),), ()), 60.0)
    follower.begin_change(15.0)
    for progress in (0.2, 0.5, 0.9):
        follower.advance(60.0 + 45.0 * progress - follower.position)
        done = 10.0 * progress**3 - 15.0 * progress**4 + 6.0 * progress**5
        start = 60.0 * math.cos(opening)  # the nearest point of the second lane
        offset = math.dist(
            (60.0 + 45.0 * progress, 0.0),
            ((start + 45.0 * progress) * math.cos(opening), (start + 45.0 * progress) * math.sin(opening)),
        )
        slope = math.copysign(offset, opening) / 45.0 * 30.0 * progress**2 * (1.0 - progress) ** 2
        turned = math.remainder(follower.yaw - angle, 2.0 * math.pi)
        assert turned == pytest.approx(done * opening + math.atan(slope), abs=1e-9)


def test_a_lane_change_is_smooth():
    follower = RouteFollower(two_lanes(), 60.0)
    follower.begin_change(15.0)
    before, step, turned = (follower.x, follower.y, follower.yaw), 15.0 * DT, 0.0
    for _ in range(60):  # three seconds
        follower.advance(step)
        moved = math.hypot(follower.x - before[0], follower.y - before[1])
        assert moved == pytest.approx(step, rel=0.05)
        turned = max(turned, abs(follower.yaw - before[2]))
        before = (follower.x, follower.y, follower.yaw)
    assert not follower.changing
    assert turned < 0.02  # [rad] a tick: no jerk of the wheel


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize(("radius", "segment"), [(10.0, 0.5), (40.0, 0.5), (40.0, 1.5)])
def test_the_curvature_nears_that_of_the_way_by_three_tenths_of_the_rest_at_each_tick(radius, segment, side):
    route, turn = circle(radius, segment, side)
    follower = RouteFollower(route, 0.5 * segment)
    for tick in range(1, int(2.0 * math.pi / turn) - 2):  # once around, over the heading of pi
        follower.advance(segment)
        assert follower.curvature == pytest.approx(turn / segment * (1.0 - 0.7**tick), rel=1e-6)
    before = follower.curvature
    follower.advance(0.0)
    assert follower.curvature == before


@pytest.mark.parametrize(("step", "measures"), [(0.9e-6, False), (1e-6, False), (1.03e-6, True), (1e-3, True)])
def test_a_way_of_a_micrometre_tells_nothing_of_the_curvature(step, measures):
    stage = stage_of([-1.0, 0.0, 1.0], [0.0, 0.0, 0.5])
    follower = RouteFollower(Route("bend", 4.7, 1.85, 2.0, 60.0, (stage,), (), ()), 1.0 - 1e-7)
    follower.advance(step)
    assert follower.yaw > 0.4
    assert (follower.curvature > 0.0) is measures


@pytest.mark.parametrize(("position", "reached"), [(289.9, False), (290.0, True), (295.0, True)])
def test_the_goal_lies_on_the_last_lane(position, reached):
    route = two_lanes()
    last = Route("t", 4.7, 1.85, 290.0, 60.0, route.stages[1:], (), ())
    assert RouteFollower(last, position).at_goal is reached
    assert not RouteFollower(route, position).at_goal


def test_the_goal_is_not_reached_within_a_lane_change():
    stages = two_lanes().stages
    route = Route("t", 4.7, 1.85, 80.0, 60.0, (*stages, stages[0]), (Window(0.0, 300.0), Window(0.0, 300.0)), ())
    follower = RouteFollower(route, 40.0)
    for _ in range(2):
        assert follower.begin_change(4.0)
        follower.advance(11.0)
        assert not follower.at_goal
        follower.advance(12.0)
    assert (follower.stage, follower.position) == (2, pytest.approx(86.0))
    assert follower.at_goal


@pytest.mark.parametrize(("position", "lost"), [(299.0, False), (300.5, False), (300.51, True), (301.2, True)])
def test_driving_past_the_end_of_a_lane_is_off_route(position, lost):
    follower = RouteFollower(two_lanes(), 290.0)
    follower.advance(position - 290.0)
    assert follower.off_route is lost
    assert not follower.at_goal


def test_who_is_changing_lanes_at_the_end_of_a_lane_is_not_lost_yet():
    stages = two_lanes(ahead=-40.0).stages
    route = Route("t", 4.7, 1.85, 200.0, 60.0, stages, (Window(50.0, 300.0),), ())
    follower = RouteFollower(route, 295.0)
    follower.begin_change(5.0)
    follower.advance(10.0)
    assert not follower.off_route
    follower.advance(10.0)
    assert not follower.off_route
    assert follower.stage == 1
