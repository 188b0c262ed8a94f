import math

import numpy as np
import pytest

from roadmend.core.command import Trajectory
from roadmend.repair.path import PathFinder
from roadmend.repair.rollout import ego_position, first_contact, is_follower, merit, roll_object

from .playground import Box, ego_at, straight_route


def rolled(box: Box, steps: int = 30, interval: float = 0.1) -> np.ndarray:
    poses = np.zeros((1, steps + 1, 4))
    poses[0, 0] = box.x, box.y, box.yaw, box.speed
    roll_object(poses[0], 0, steps, box.yaw_rate, box.acceleration, interval)
    return poses


def test_constant_velocity():
    poses = rolled(Box(1, 1.0, 2.0, 0.5, 8.0))
    assert poses[0, 30, 0] == pytest.approx(1.0 + 24.0 * math.cos(0.5))
    assert poses[0, 30, 1] == pytest.approx(2.0 + 24.0 * math.sin(0.5))


def test_constant_yaw_rate_closes_the_circle():
    poses = rolled(Box(1, 0.0, 0.0, 0.0, 8.0, yaw_rate=2.0 * math.pi / 3.0))
    assert poses[0, 30, :2] == pytest.approx([0.0, 0.0], abs=1e-6)
    assert poses[0, 15, 1] == pytest.approx(2.0 * 8.0 * 3.0 / (2.0 * math.pi), rel=0.01)


def test_braking_ends_at_standstill():
    poses = rolled(Box(1, 0.0, 0.0, 0.0, 6.0, acceleration=-4.0))
    assert poses[0, 30, 0] == pytest.approx(4.5, abs=0.05)
    assert poses[0, 30, 3] == 0.0


@pytest.mark.parametrize(
    ("deceleration", "time", "position"),
    [(-1.0, 2.0, 20.0), (0.0, 2.0, 16.0), (4.0, 1.0, 6.0), (4.0, 2.0, 8.0), (4.0, 9.0, 8.0)],
)
def test_the_ego_goes_no_farther_than_planned_or_braked(deceleration, time, position):
    progress = np.arange(0.0, 31.0)  # planned: 10 m/s
    assert ego_position(progress, 0.1, 10.0, 8.0, deceleration, time) == pytest.approx(position)
    assert ego_position(np.zeros(2), 0.1, 0.0, 8.0, deceleration, time) == 0.0


def world(box: Box, speed: float = 10.0):
    finder = PathFinder()
    finder.reset(straight_route())
    path = finder.find(ego_at(speed=speed), Trajectory.empty(), 60.0)
    plan = (path.points, path.count, path.progress, path.interval, path.tail_speed, speed, 4.5, 1.8)
    return plan, rolled(box), np.array([box.length]), np.array([box.width])


@pytest.mark.parametrize(("gap", "step"), [(0.0, 0), (0.95, 1), (10.05, 11), (29.95, 30), (30.05, -1)])
def test_contact_comes_when_the_gap_is_used_up(gap, step):
    plan, poses, length, width = world(Box(1, 4.5 + gap, 0.0))
    found = first_contact(*plan, -1.0, poses, length, width, np.zeros(1), 0, 30, -1, 0.1)
    assert found == (step, 0 if step >= 0 else -1)


def test_contact_within_the_required_gap_and_not_with_those_left_out():
    plan, poses, length, width = world(Box(1, 10.0, 3.0))
    for required, meets in ((1.1, False), (1.3, True), (-1.0, False)):
        step, _ = first_contact(*plan, -1.0, poses, length, width, np.array([required]), 0, 30, -1, 0.1)
        assert (step >= 0) == meets


def test_contact_of_the_focus_only():
    plan, poses, length, width = world(Box(1, 10.0, 0.0))
    both = np.concatenate([rolled(Box(2, 40.0, 20.0)), poses])
    sizes = np.repeat(length, 2), np.repeat(width, 2)
    assert first_contact(*plan, -1.0, both, *sizes, np.zeros(2), 0, 30, 0, 0.1)[0] == -1
    assert first_contact(*plan, -1.0, both, *sizes, np.zeros(2), 0, 30, 1, 0.1)[1] == 1


def test_merit_is_the_least_gap_or_the_speed_of_the_impact():
    plan, poses, length, width = world(Box(1, 10.0, 3.0))
    assert merit(*plan, -1.0, poses, length, width, np.zeros(1), 30, 0.1) == pytest.approx(1.2, abs=1e-6)
    plan, poses, length, width = world(Box(1, 8.0, 0.0))
    assert merit(*plan, -1.0, poses, length, width, np.zeros(1), 30, 0.1) == pytest.approx(-10.0)
    assert -8.0 < merit(*plan, 8.0, poses, length, width, np.zeros(1), 30, 0.1) < -6.0
    assert merit(*plan, -1.0, poses, length, width, -np.ones(1), 30, 0.1) == math.inf


@pytest.mark.parametrize(
    ("box", "follows"),
    [
        (Box(1, -8.0, 0.0), True),
        (Box(1, -8.0, 1.5, 0.3), True),
        (Box(1, -8.0, 3.2), False),
        (Box(1, -3.0, 0.0), False),
        (Box(1, 8.0, 0.0), False),
        (Box(1, -8.0, 0.0, 1.5), False),
    ],
)
def test_followers_are_those_behind_on_the_same_lane(box, follows):
    plan, _, _, _ = world(box)
    assert is_follower(plan[0], plan[1], 4.5, 1.8, box.x, box.y, box.yaw, box.length, box.width) == follows
