import math

import numpy as np
import pytest

from roadmend.core.command import Trajectory
from roadmend.repair.contact import Forecast, braked_position, first_contact, is_follower, merit, roll_object
from roadmend.repair.planned_path import PathFinder, planned_position

from .playground import Box, ego_at, object_list, straight_route


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
    path = path_of(10.0)
    assert braked_position(planned_position(path, time), 8.0, deceleration, time) == pytest.approx(position)
    still = path._replace(progress=np.zeros(2), tail_speed=0.0)
    assert braked_position(planned_position(still, time), 8.0, deceleration, time) == 0.0


def path_of(speed: float):
    finder = PathFinder()
    finder.reset(straight_route())
    return finder.find(ego_at(speed=speed), Trajectory.empty(), 60.0)


def forecast_of(required: float, *boxes: Box) -> Forecast:
    """Some objects rolled forward, of which each must keep a gap [m]."""
    poses = np.concatenate([rolled(box) for box in boxes])
    return Forecast(object_list(boxes).table, poses, np.full(len(boxes), required), 0.1)


@pytest.mark.parametrize(("gap", "step"), [(0.0, 0), (0.95, 1), (10.05, 11), (29.95, 30), (30.05, -1)])
def test_contact_comes_when_the_gap_is_used_up(gap, step):
    forecast = forecast_of(0.0, Box(1, 4.5 + gap, 0.0))
    found = first_contact(path_of(10.0), ego_at(), -1.0, forecast, 0, 30, -1)
    assert found == (step, 0 if step >= 0 else -1)


def test_contact_within_the_required_gap_and_not_with_those_left_out():
    for required, meets in ((1.1, False), (1.3, True), (-1.0, False)):
        forecast = forecast_of(required, Box(1, 10.0, 3.0))
        assert (first_contact(path_of(10.0), ego_at(), -1.0, forecast, 0, 30, -1)[0] >= 0) == meets


def test_contact_of_the_focus_only():
    both = forecast_of(0.0, Box(2, 40.0, 20.0), Box(1, 10.0, 0.0))
    assert first_contact(path_of(10.0), ego_at(), -1.0, both, 0, 30, 0)[0] == -1
    assert first_contact(path_of(10.0), ego_at(), -1.0, both, 0, 30, 1)[1] == 1


def test_merit_is_the_least_gap_or_the_speed_of_the_impact():
    path, ego = path_of(10.0), ego_at()
    assert merit(path, ego, -1.0, forecast_of(0.0, Box(1, 10.0, 3.0)), 30) == pytest.approx(1.2, abs=1e-6)
    ahead = forecast_of(0.0, Box(1, 8.0, 0.0))
    assert merit(path, ego, -1.0, ahead, 30) == pytest.approx(-10.0)
    assert -8.0 < merit(path, ego, 8.0, ahead, 30) < -6.0
    assert merit(path, ego, -1.0, forecast_of(-1.0, Box(1, 8.0, 0.0)), 30) == math.inf


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
    assert is_follower(path_of(10.0), ego_at(), object_list([box]).table[0]) == follows
