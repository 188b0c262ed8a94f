import math

import numpy as np
import pytest

from roadmend.core.route import Route, RouteTracker, Stage


def straight(y=0.0, length=100.0):
    x = np.arange(0.0, length + 1.0, 10.0)
    return Stage(x, np.full_like(x, y), np.full_like(x, 13.9))


def test_pose_and_projection_are_inverse():
    angles = np.linspace(0.0, math.pi / 2, 60)
    stage = Stage(30 * np.sin(angles), 30 - 30 * np.cos(angles), np.full(60, 10.0))
    for position in np.linspace(0.5, stage.length - 0.5, 17):
        x, y, _ = stage.pose(position)
        found, offset = stage.project(x, y, position)
        assert found == pytest.approx(position, abs=1e-6)
        assert offset == pytest.approx(0.0, abs=1e-6)


def test_offset_is_positive_to_the_left():
    assert straight().project(50.0, 2.0, 50.0) == (50.0, 2.0)
    assert straight().project(50.0, -2.0, 50.0) == (50.0, -2.0)


def test_the_line_goes_straight_on_beyond_its_ends():
    assert straight().pose(120.0) == (120.0, 0.0, 0.0)
    assert straight().pose(-10.0) == (-10.0, 0.0, 0.0)


def test_the_tracker_finds_the_nearest_stage_and_where_one_is_on_each():
    tracker = RouteTracker(Route("t", 4.7, 1.85, 90.0, 60.0, (straight(0.0), straight(3.2)), (), ()))
    assert tracker.observe(42.0, 3.0) == 1
    assert tracker.observe(43.0, 0.4) == 0
    assert [place[0] for place in tracker.places] == [43.0, 43.0]
    assert [place[1] for place in tracker.places] == pytest.approx([0.4, -2.8])


def test_the_tracker_stays_on_its_branch_where_the_route_crosses_itself():
    x = np.concatenate(
        [np.linspace(0.0, 100.0, 101), np.full(50, 100.0), np.linspace(100.0, 50.0, 51), np.full(100, 50.0)]
    )
    y = np.concatenate([np.zeros(101), np.linspace(1.0, 50.0, 50), np.full(51, 50.0), np.linspace(49.0, -50.0, 100)])
    tracker = RouteTracker(Route("t", 4.7, 1.85, 200.0, 190.0, (Stage(x, y, np.full(len(x), 10.0)),), (), ()))
    tracker.observe(20.0, 0.5)
    for ahead in range(21, 61):
        tracker.observe(float(ahead), 0.5)
        assert tracker.places[0][0] == pytest.approx(ahead, abs=1e-6)


def test_who_turns_up_far_from_the_last_place_is_looked_for_on_the_whole_route():
    tracker = RouteTracker(Route("t", 4.7, 1.85, 900.0, 60.0, (straight(0.0, 900.0), straight(3.2, 900.0)), (), ()))
    tracker.observe(10.0, 0.0)
    for x, y, nearest in ((200.0, 0.4, 0), (870.0, 3.0, 1), (5.0, 0.0, 0)):
        assert tracker.observe(x, y) == nearest
        assert tracker.places[0] == pytest.approx((x, y))
