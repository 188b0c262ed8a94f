import math

import numpy as np
import pytest

from roadmend.core.command import Command, Decision, Trajectory
from roadmend.core.repair import RepairStatus
from roadmend.core.scene import EgoState
from roadmend.repair.assumed_motion import INTERVAL, POINTS, AssumedMotion, Assumption, is_open, open_route
from roadmend.repair.registry import METHODS, make_repairer
from roadmend.repair.sanitise import is_usable_plan

from .playground import Box, curved_route, ego_at, scene_of, straight_route, two_lane_route

TIMES = INTERVAL * np.arange(1, POINTS + 1)


def assume(ego, route=None):
    motion = AssumedMotion()
    motion.reset(route)
    return motion.trajectory(ego), motion.assumption


def ego_turning(yaw_rate, speed=8.0, yaw=0.3):
    return EgoState.from_yaw(5.0, -2.0, yaw, speed, yaw_rate, 4.5, 1.8)


def test_along_the_route_at_the_present_speed():
    plan, assumption = assume(ego_at(x=-10.0, speed=10.0), curved_route(radius=20.0))
    assert assumption is Assumption.ALONG_ROUTE
    np.testing.assert_allclose(plan.speed, 10.0)
    on_arc = math.hypot(plan.x[9], plan.y[9] - 20.0)  # after 25 m: 10 m to the bend and 15 m in it
    assert on_arc == pytest.approx(20.0, abs=0.1)
    assert plan.yaw[9] == pytest.approx(15.0 / 20.0, abs=0.05)
    way = np.hypot(np.diff(plan.x), np.diff(plan.y))
    np.testing.assert_allclose(way, 2.5, atol=0.05)


def test_beside_the_lane_it_comes_back_to_the_centre():
    plan, _ = assume(ego_at(y=1.0), straight_route())
    assert plan.y[0] < 1.0
    assert plan.y[-1] == pytest.approx(0.0, abs=1e-6)


def test_of_two_lanes_the_nearest_counts():
    plan, _ = assume(ego_at(y=3.0), two_lane_route())
    assert plan.y[-1] == pytest.approx(3.2, abs=1e-6)


@pytest.mark.parametrize(
    ("ego", "route"),
    [
        (ego_turning(0.0), None),
        (ego_at(y=5.5), straight_route()),  # too far beside
        (ego_at(yaw=1.1), straight_route()),  # across
        (ego_turning(0.0), open_route(4.5, 1.8)),
    ],
)
def test_off_the_route_it_goes_straight_on(ego, route):
    plan, assumption = assume(ego, route)
    assert assumption is Assumption.PRESENT_TURN
    np.testing.assert_allclose(plan.x, ego.x + ego.speed * TIMES * math.cos(ego.yaw))
    np.testing.assert_allclose(plan.y, ego.y + ego.speed * TIMES * math.sin(ego.yaw))
    np.testing.assert_allclose(plan.yaw, ego.yaw)


@pytest.mark.parametrize("yaw_rate", [0.4, -0.4])
def test_a_turn_is_kept_as_a_circle(yaw_rate):
    ego = ego_turning(yaw_rate)
    plan, _ = assume(ego)
    radius = ego.speed / yaw_rate
    centre = ego.x - radius * math.sin(ego.yaw), ego.y + radius * math.cos(ego.yaw)
    np.testing.assert_allclose(np.hypot(plan.x - centre[0], plan.y - centre[1]), abs(radius), rtol=2e-3)
    assert plan.yaw[3] == pytest.approx(ego.yaw + yaw_rate)


@pytest.mark.parametrize("speed", [0.0, -2.0])
@pytest.mark.parametrize("route", [None, straight_route()])
def test_who_stands_or_rolls_back_is_assumed_to_stand(speed, route):
    plan, _ = assume(ego_at(x=3.0, speed=speed), route)
    np.testing.assert_allclose(plan.x, 3.0)
    np.testing.assert_allclose(plan.speed, 0.0)


@pytest.mark.parametrize("bad", [math.nan, math.inf])
@pytest.mark.parametrize("field", ["x", "y", "yaw", "speed", "yaw_rate"])
def test_an_ego_that_is_not_finite_has_no_trajectory(field, bad):
    motion = AssumedMotion()
    motion.reset(None)
    decision = motion.decide(ego_at()._replace(**{field: bad}), Command(0.2, 0.0))
    assert len(decision.trajectory) == 0
    assert decision.command == Command(0.2, 0.0)


def test_it_is_a_trajectory_that_the_guard_takes():
    plan, _ = assume(ego_turning(0.2))
    assert is_usable_plan(plan.interval, plan.x, plan.y, plan.yaw, plan.speed)


def test_where_plans_end_that_were_there_for_a_while_the_route_is_found_again():
    motion = AssumedMotion()
    motion.reset(curved_route(radius=20.0))
    motion.trajectory(ego_at(x=-45.0))
    plan = motion.trajectory(ego_at(x=20.0, y=80.0, yaw=0.5 * math.pi))  # 145 m on, of which a plan was there
    assert motion.assumption is Assumption.ALONG_ROUTE
    np.testing.assert_allclose(plan.x, 20.0, atol=1e-6)


def test_a_new_episode_forgets_the_route():
    motion = AssumedMotion()
    motion.reset(straight_route())
    motion.trajectory(ego_at())
    motion.reset(None)
    motion.trajectory(ego_at())
    assert motion.assumption is Assumption.PRESENT_TURN


def test_only_an_open_route_is_open():
    assert is_open(open_route(4.5, 1.8))
    assert not is_open(straight_route())


def drive(method, boxes, ego, ticks=3):
    """The last of the answers to the same scene, without a route and a plan."""
    repairer = make_repairer(method)
    repairer.reset(open_route(4.5, 1.8))
    motion = AssumedMotion()
    motion.reset(None)
    for index in range(ticks):
        scene = scene_of(boxes, 1.0 + 0.05 * index, ego)
        repair = repairer.step(scene, motion.decide(ego, Command(0.3, 0.0)))
    return repair


@pytest.mark.parametrize("method", sorted(set(METHODS) - {"random"}))
@pytest.mark.parametrize("ego", [ego_at(speed=12.0), ego_at(x=7e5, y=4e6, yaw=2.0, speed=12.0)])
def test_every_method_works_without_a_route(method, ego):
    repair = drive(method, [Box(1, ego.x + 300.0, ego.y + 300.0)], ego)
    assert repair.status in (RepairStatus.PASS, RepairStatus.REPAIRED), repair.reason


@pytest.mark.parametrize("method", ["rss", "predictive", "rule"])
@pytest.mark.parametrize("at", [(0.0, 0.0, 0.0), (7e5, 4e6, 2.0)])
def test_without_a_route_rules_brake_for_who_stands_ahead_and_for_nobody_beside(method, at):
    x, y, yaw = at
    ego = ego_at(x, y, yaw, speed=12.0)
    ahead = Box(1, x + 12.0 * math.cos(yaw), y + 12.0 * math.sin(yaw), yaw)
    beside = Box(1, x - 12.0 * math.sin(yaw), y + 12.0 * math.cos(yaw), yaw)
    braking = drive(method, [ahead], ego)
    assert braking.intervened
    assert braking.final_action < -0.2
    assert [trigger.object_id for trigger in braking.triggers] == [1]
    assert not drive(method, [beside], ego).intervened


def test_the_assumption_makes_a_difference_to_models_that_look_at_the_plan():
    repairer = make_repairer("predictive")
    repairer.reset(open_route(4.5, 1.8))
    motion = AssumedMotion()
    motion.reset(None)
    ego = ego_turning(0.5, speed=10.0, yaw=0.0)
    plan = motion.trajectory(ego)
    scene = scene_of([Box(1, float(plan.x[7]), float(plan.y[7]), float(plan.yaw[7]))], 1.0, ego)
    assert repairer.step(scene, Decision(Command(0.3, 0.0), plan)).intervened
    repairer.reset(open_route(4.5, 1.8))
    assert not repairer.step(scene, Decision(Command(0.3, 0.0), Trajectory.empty())).intervened
