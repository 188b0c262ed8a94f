import math

import numpy as np
import pytest

from roadmend.core.command import Trajectory
from roadmend.repair.planned_path import PathFinder, coordinates_on, planned_position, planned_time, pose_on
from roadmend.repair.sanitise import MANY

from .playground import curved_route, ego_at, keep_on, scene_of, straight_route, two_lane_route


def find(route, ego, trajectory=None, ahead=80.0):
    finder = PathFinder()
    finder.reset(route)
    return finder.find(ego, trajectory or Trajectory.empty(), ahead)


def test_without_a_plan_the_path_is_the_route():
    path = find(curved_route(), ego_at(-10.0))
    assert path.points[2, path.zero] == 0.0
    assert path.points[2, path.size - 1] >= 79.0
    assert path.points[2, 0] == pytest.approx(-60.0, abs=0.5)
    x, y, yaw = pose_on(path, 10.0 + 0.5 * math.pi * 20.0 + 20.0)
    assert x == pytest.approx(20.0, abs=0.1)
    assert y == pytest.approx(40.0, abs=0.5)
    assert yaw == pytest.approx(0.5 * math.pi, abs=0.02)
    assert planned_position(path, 2.0) == 20.0


def test_arc_lengths_are_those_of_the_points():
    path = find(curved_route(), ego_at(-10.0))
    points = path.points[:, : path.size]
    steps = np.hypot(np.diff(points[0]), np.diff(points[1]))
    np.testing.assert_allclose(np.diff(points[2]), steps, atol=1e-9)
    assert (steps > 0.05).all()


def test_the_plan_comes_before_the_route():
    scene = scene_of([], ego=ego_at(speed=8.0))
    plan = keep_on(scene, speed=6.0).trajectory
    path = find(straight_route(), scene.ego, plan)
    for time in (0.0, 0.05, 0.1, 1.37, 3.0, 4.0):
        assert planned_position(path, time) == pytest.approx(6.0 * time)
        assert planned_time(path, 6.0 * time) == pytest.approx(time)


def test_a_plan_that_stops_never_arrives():
    way = np.minimum(5.0, np.arange(1, 31) * 0.5)
    speed = np.where(way < 5.0, 5.0, 0.0)
    path = find(straight_route(), ego_at(), Trajectory(0.1, way, np.zeros(30), np.zeros(30), speed))
    assert planned_time(path, 4.9) < 1.0
    assert planned_time(path, 5.1) == math.inf
    assert planned_time(path, -1.0) == 0.0
    assert path.points[2, path.size - 1] > 60.0  # the path goes on all the same


def test_a_plan_at_rest_is_no_way():
    point = np.zeros(30)
    path = find(straight_route(), ego_at(speed=0.0), Trajectory(0.1, point, point, point, point))
    assert (path.progress == 0.0).all()
    assert path.tail_speed == 0.0


def test_off_the_lane_the_path_returns_to_it():
    path = find(straight_route(), ego_at(0.0, 1.5))
    assert pose_on(path, 0.0)[1] == pytest.approx(1.5)
    assert pose_on(path, 40.0)[1] == pytest.approx(0.0, abs=1e-6)
    assert pose_on(path, -40.0)[1] == pytest.approx(1.5)


def test_far_off_the_route_it_goes_straight_on():
    path = find(straight_route(), ego_at(0.0, 50.0, 0.3))
    assert pose_on(path, 50.0)[1] == pytest.approx(50.0 + 50.0 * math.sin(0.3), abs=1e-6)
    assert pose_on(path, -50.0)[1] == pytest.approx(50.0 - 50.0 * math.sin(0.3), abs=1e-6)


def test_a_lane_change_is_followed_into_the_next_stage():
    times = np.arange(1, 31) * 0.1
    plan = Trajectory(0.1, 10.0 * times, 3.2 * times / 3.0, np.full(30, 0.1), np.full(30, 10.0))
    path = find(two_lane_route(), ego_at(), plan)
    assert path.stage == 0
    assert pose_on(path, 60.0)[1] == pytest.approx(3.2, abs=1e-6)
    assert pose_on(path, -30.0)[1] == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("s", [-40.0, -5.0, 0.0, 12.3, 41.7, 70.0])
@pytest.mark.parametrize("d", [-3.0, 0.0, 2.0])
def test_coordinates_invert_poses_on_a_curve(s, d):
    path = find(curved_route(), ego_at(-10.0))
    x, y, yaw = pose_on(path, s)
    found = coordinates_on(path, x - d * math.sin(yaw), y + d * math.cos(yaw), yaw + 0.2)
    assert found[0] == pytest.approx(s, abs=0.15)
    assert found[1] == pytest.approx(d, abs=0.05)
    assert found[2] == pytest.approx(0.2, abs=0.05)


def test_the_place_on_the_route_is_followed_from_tick_to_tick():
    finder = PathFinder()
    finder.reset(curved_route())
    for position in np.arange(0.0, 100.0, 0.5):
        x, y, yaw = curved_route().stages[0].pose(position)
        path = finder.find(ego_at(x, y, yaw), Trajectory.empty(), 60.0)
        assert path.stage_positions[0] == pytest.approx(position, abs=1e-6)


def test_a_long_plan_fits_its_buffer():
    times = np.arange(1, 3001) * 0.1
    plan = Trajectory(0.1, 10.0 * times, np.zeros(3000), np.zeros(3000), np.full(3000, 10.0))
    path = find(straight_route(), ego_at(), plan)
    assert path.size <= path.points.shape[1]
    assert np.isfinite(path.points[:, : path.size]).all()


def test_the_longest_usable_plan_is_kept_to_its_end_and_the_path_goes_on():
    times = np.arange(1, MANY + 1) * 0.01
    plan = Trajectory(0.01, 30.0 * times, np.zeros(MANY), np.zeros(MANY), np.full(MANY, 30.0))
    path = find(straight_route(), ego_at(speed=30.0), plan, ahead=350.0)
    for time in (0.005, 3.0, 0.01 * MANY, 10.0):
        assert planned_position(path, time) == pytest.approx(30.0 * time)
    assert path.points[2, path.size - 1] >= 350.0


def test_without_a_route_there_is_no_path():
    with pytest.raises(RuntimeError, match="route"):
        PathFinder().find(ego_at(), Trajectory.empty(), 50.0)
