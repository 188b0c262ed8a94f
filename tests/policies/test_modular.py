"""Behaviour of the modular policy as figures of short drives."""

import math

import numpy as np
import pytest

from roadmend.core.command import Decision
from roadmend.core.route import RightOfWay, Route, Stage, Window
from roadmend.core.scene import Signal
from roadmend.policies.modular import ModularPolicy

from .proving_ground import TICK, Body, drive, road, scene_at, straight, two_lanes, walker, zone

NORTH, SOUTH = 0.5 * math.pi, -0.5 * math.pi


@pytest.fixture(scope="module")
def policy() -> ModularPolicy:
    return ModularPolicy()


def stopped_at(run) -> float:
    assert run.speed[-1] < 0.05
    return run.x[-1] + 0.5 * 4.7


def test_drives_near_the_limit_when_the_road_is_free(policy):
    run = drive(policy, road(), 15.0, 5.0, 0.0)
    assert run.speed[-1] == pytest.approx(13.9, abs=0.4)
    assert max(run.speed) < 14.3
    assert max(run.acceleration) < 3.0
    assert run.words == {"cruise"}


def test_stops_comfortably_behind_a_standing_vehicle(policy):
    run = drive(policy, road(), 25.0, 5.0, 12.0, [Body(1, 150.0, 0.0)])
    assert 1.0 < 150.0 - 2.3 - stopped_at(run) < 4.0
    assert min(run.acceleration) > -4.0
    assert "follow" in run.words
    assert run.decisions[-1].command.brake > 0.0


def test_follows_with_a_time_gap(policy):
    run = drive(policy, road(length=800.0), 30.0, 5.0, 10.0, [Body(1, 40.0, 0.0, speed=10.0)])
    assert run.speed[-1] == pytest.approx(10.0, abs=0.3)
    assert 8.0 < run.gap < 25.0


def test_survives_a_leader_that_brakes_hard(policy):
    run = drive(policy, road(length=800.0), 12.0, 5.0, 13.0, [Body(1, 32.0, 0.0, speed=13.0, acceleration=-7.0)])
    assert run.gap > 0.5


def test_holds_for_red_and_goes_on_green(policy):
    light = road(zone(120.0, 140.0, RightOfWay.SIGNAL))
    red = drive(policy, light, 20.0, 5.0, 12.0, signals=lambda _: (Signal.RED,))
    assert 0.0 < 120.0 - stopped_at(red) < 2.5
    assert min(red.acceleration) > -4.0
    assert "signal" in red.words
    run = drive(policy, light, 30.0, 5.0, 12.0, signals=lambda t: (Signal.RED if t < 20.0 else Signal.GREEN,))
    assert run.x[-1] > 140.0


@pytest.mark.parametrize(("distance", "stops"), [(15.0, False), (60.0, True)])
def test_stops_for_yellow_only_where_that_is_comfortable(policy, distance, stops):
    light = road(zone(200.0, 220.0, RightOfWay.SIGNAL))
    run = drive(policy, light, 12.0, 200.0 - 2.35 - distance, 12.5, signals=lambda _: (Signal.YELLOW,))
    assert (run.x[-1] < 200.0) == stops


def test_stops_once_at_a_stop_sign(policy):
    run = drive(policy, road(zone(100.0, 115.0, RightOfWay.STOP)), 25.0, 5.0, 12.0)
    standing = [x for x, speed in zip(run.x, run.speed, strict=True) if speed < 0.1]
    assert standing
    assert 95.0 < standing[0] + 2.35 < 100.0
    assert run.x[-1] > 120.0


def test_yields_to_crossing_traffic_and_goes_when_it_has_passed(policy):
    crossing = road(zone(100.0, 115.0, RightOfWay.YIELD))
    others = [Body(number, 107.0, -60.0 - 22.0 * number, NORTH, 11.0) for number in range(4)]
    run = drive(policy, crossing, 30.0, 40.0, 11.0, others)
    assert run.gap > 1.0
    assert "yield" in run.words
    assert run.x[-1] > 115.0


def test_does_not_stop_for_traffic_that_has_left(policy):
    crossing = road(zone(100.0, 115.0, RightOfWay.YIELD))
    free = drive(policy, crossing, 10.0, 40.0, 11.0)
    run = drive(policy, crossing, 10.0, 40.0, 11.0, [Body(1, 107.0, 12.0, NORTH, 11.0)])
    assert run.x[-1] == pytest.approx(free.x[-1], abs=0.5)


def test_trusts_those_who_must_give_way_until_they_cannot_any_more(policy):
    crossing = road(zone(100.0, 115.0, RightOfWay.PRIORITY))
    braking = drive(policy, crossing, 6.0, 40.0, 13.0, [Body(1, 107.0, -33.0, NORTH, 9.0, acceleration=-1.6)])
    assert min(braking.speed) > 12.0
    running = drive(policy, crossing, 12.0, 40.0, 13.0, [Body(1, 107.0, -66.0, NORTH, 13.0)])
    assert running.gap > 0.2
    assert min(running.acceleration) < -1.0


def test_brakes_for_a_pedestrian_on_the_crossing(policy):
    zebra = road(zone(100.0, 105.0, RightOfWay.CROSSING))
    run = drive(policy, zebra, 20.0, 40.0, 11.0, [walker(1, 103.0, -8.0, NORTH, 1.3)])
    assert run.gap > 0.8
    assert "crossing" in run.words
    assert run.x[-1] > 110.0


def test_does_not_wait_for_a_pedestrian_who_stands_at_the_kerb(policy):
    run = drive(
        policy, road(zone(100.0, 105.0, RightOfWay.CROSSING)), 12.0, 40.0, 11.0, [walker(1, 103.0, -4.0, NORTH, 0.0)]
    )
    assert min(run.speed) > 10.0


def test_merges_into_a_gap(policy):
    others = [Body(number, 60.0 * number - 40.0, 3.2, 0.0, 18.0) for number in range(5)]
    run = drive(policy, two_lanes(), 14.0, 5.0, 15.0, others)
    assert run.y[-1] == pytest.approx(3.2)
    assert run.gap > 1.0
    assert {"merge", "change"} <= run.words


def test_waits_at_the_end_of_the_window_while_there_is_no_gap(policy):
    wall = [Body(number, 8.0 * number - 200.0, 3.2, 0.0, 0.0) for number in range(60)]
    run = drive(policy, two_lanes(), 30.0, 5.0, 15.0, wall)
    assert run.x[-1] <= 150.0
    assert run.y[-1] == 0.0
    assert min(run.acceleration) > -6.0


def test_slows_down_for_a_curve_before_it_begins(policy):
    angle = np.linspace(0.0, 0.5 * math.pi, 16)
    stage = straight(100.0)
    x = np.concatenate([stage.x, 100.0 + 10.0 * np.sin(angle[1:])])
    y = np.concatenate([stage.y, 10.0 - 10.0 * np.cos(angle[1:])])
    bend = type(stage)(x, y, np.full(len(x), 13.9))
    run = drive(policy, Route("bend", 4.7, 1.85, 110.0, 60.0, (bend,), (), ()), 9.0, 5.0, 13.0)
    there = next(speed for x, speed in zip(run.x, run.speed, strict=True) if x > 100.0)
    assert there < math.sqrt(2.5 * 10.0) + 0.7
    assert min(run.acceleration) > -3.5


def test_plans_are_continuous_in_space_and_time(policy):
    run = drive(policy, two_lanes(), 12.0, 5.0, 15.0, [Body(1, 120.0, 0.0, speed=12.0)])
    for decision, x, speed in zip(run.decisions[1:], run.x, run.speed, strict=False):
        plan = decision.trajectory
        steps = np.hypot(np.diff(plan.x), np.diff(plan.y))
        assert np.all(steps <= np.maximum(plan.speed[:-1], plan.speed[1:]) * plan.interval * 1.1 + 0.05)
        # Between two plans the last one is given again, so it may be one tick old.
        assert abs(plan.x[0] - x - speed * plan.interval) < 0.6 + 0.05 * speed
        assert np.all(np.abs(np.diff(np.unwrap(plan.yaw))) < 0.2)


def test_the_same_scenes_give_the_same_bits_after_a_reset(policy):
    others = [Body(number, 60.0 * number - 40.0, 3.2, 0.0, 18.0) for number in range(5)]
    first = drive(policy, two_lanes(), 8.0, 5.0, 15.0, others)
    second = drive(policy, two_lanes(), 8.0, 5.0, 15.0, others)
    third = drive(ModularPolicy(), two_lanes(), 8.0, 5.0, 15.0, others)
    assert first.x == second.x == third.x
    assert [d.command for d in first.decisions] == [d.command for d in second.decisions]


@pytest.mark.parametrize("progress", [0.3, 0.5, 0.8])
def test_finds_its_place_when_started_in_the_middle_of_a_change(progress):
    policy = ModularPolicy()
    policy.reset(two_lanes())
    decision = policy.step(scene_at(12.3, 100.0, 15.0, y=3.2 * progress))
    plan = decision.trajectory
    assert plan.y[-1] == pytest.approx(3.2, abs=0.05)
    assert np.all(np.diff(plan.y) >= -1e-9)


def test_started_in_line_with_a_lane_that_has_ended_it_drives_on(policy):
    # A pocket for turning left ends at 200 m; the lane to its right goes on, beyond the junction in line with it.
    x = np.r_[np.linspace(0.0, 200.0, 5), np.linspace(230.0, 800.0, 8)]
    on = Stage(x, np.where(x > 200.0, 0.0, -3.2), np.full(13, 13.9))
    pocket = Route("pocket", 4.7, 1.85, 780.0, 120.0, (straight(200.0), on), (Window(20.0, 150.0),), ())
    run = drive(policy, pocket, 10.0, 400.0, 12.0)
    assert min(run.speed) > 11.9
    assert run.words == {"cruise"}


def same(decision: Decision) -> tuple[float, float]:
    return decision.command.throttle, decision.command.brake


@pytest.mark.parametrize(
    ("x", "y", "speed"),
    [
        (395.0, 0.0, 10.0),
        (2000.0, 0.0, 10.0),
        (-50.0, 0.0, 0.0),
        (50.0, 80.0, 5.0),
        (50.0, 0.0, 0.0),
        (50.0, 0.0, 60.0),
    ],
)
def test_answers_wherever_the_ego_is(policy, x, y, speed):
    policy.reset(road(zone(100.0, 110.0, RightOfWay.SIGNAL)))
    decision = policy.step(scene_at(0.0, x, speed, y=y))  # the light is not even in the list
    assert decision.command.fault == ""
    assert np.all(np.isfinite(decision.trajectory.x))


@pytest.mark.parametrize("what", ["x", "y", "yaw", "speed", "acceleration", "length", "width"])
@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_ignores_objects_that_are_not_finite(policy, what, value):
    policy.reset(road())
    clean = policy.step(scene_at(0.0, 20.0, 10.0))
    policy.reset(road())
    poisoned = policy.step(scene_at(0.0, 20.0, 10.0, [Body(1, **({"x": 40.0, "y": 0.0} | {what: value}))]))
    assert same(poisoned) == same(clean)


def test_brakes_where_the_ego_is_unknown(policy):
    policy.reset(road())
    assert policy.step(scene_at(0.0, math.nan, 10.0)).command.brake > 0.0
    assert ModularPolicy().step(scene_at(0.0, 0.0, 10.0)).command.brake > 0.0


def test_a_clock_that_runs_backwards_is_a_new_beginning(policy):
    policy.reset(road())
    policy.step(scene_at(5.0, 20.0, 10.0))
    again = policy.step(scene_at(1.0, 300.0, 10.0))
    assert again.trajectory.x[0] == pytest.approx(300.0 + 10.0 * 0.25, abs=0.5)


def test_never_presses_both_pedals_and_holds_the_brake_at_standstill(policy):
    run = drive(policy, road(), 25.0, 5.0, 12.0, [Body(1, 100.0, 0.0)])
    standing = [d.command for d, speed in zip(run.decisions[1:], run.speed, strict=False) if speed < 0.05]
    assert standing
    assert all(command.throttle == 0.0 and command.brake >= 0.1 for command in standing[-round(2.0 / TICK) :])
