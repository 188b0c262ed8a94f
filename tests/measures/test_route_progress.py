"""Where on its route the ego is, by hand-made routes."""

import numpy as np
import pytest

from roadmend.core.route import Route, Stage, Window
from roadmend.core.scene import EgoState
from roadmend.measures.route_progress import RouteProgress


def lane(x, y):
    return Stage(np.array(x, dtype=float), np.array(y, dtype=float), np.full(len(x), 14.0))


def route(*stages, windows=(), goal=100.0):
    return Route("drawn", 4.0, 2.0, goal, 60.0, stages, windows, ())


def ego(x, y):
    return EgoState.from_yaw(x, y, 0.0, 10.0, 0.0, 4.0, 2.0)


def test_on_one_lane_it_is_the_share_of_the_way_from_the_start_to_the_goal():
    progress = RouteProgress(route(lane([0, 150], [0, 0])))
    assert progress.completion(progress.observe(ego(20.0, 0.0))) == 0.0
    assert progress.completion(progress.observe(ego(40.0, 0.3))) == pytest.approx(0.25)
    assert progress.completion(progress.observe(ego(100.0, 0.0))) == 1.0
    assert progress.completion(progress.observe(ego(120.0, 0.0))) == 1.0


def test_a_lane_change_counts_from_where_its_window_opens_and_costs_no_way():
    stages = lane([0, 200], [0, 0]), lane([50, 300], [-3, -3])
    progress = RouteProgress(route(*stages, windows=(Window(60.0, 120.0),), goal=150.0))
    before = progress.observe(ego(0.0, 0.0))
    assert (before.stage, progress.left(before)) == (0, pytest.approx(200.0))
    late = progress.observe(ego(25.0, 0.0))
    assert progress.left(late) == pytest.approx(175.0)
    changed = progress.observe(ego(50.0, -3.0))
    assert (changed.stage, progress.left(changed)) == (1, pytest.approx(150.0))
    assert progress.completion(changed) == pytest.approx(0.25)


def test_who_stays_in_the_wrong_lane_does_not_come_nearer_than_that_lane_leads():
    stages = lane([0, 100], [0, 0]), lane([0, 300], [-3, -3])
    progress = RouteProgress(route(*stages, windows=(Window(10.0, 60.0),), goal=250.0))
    progress.observe(ego(0.0, 0.0))
    end = progress.observe(ego(100.0, 0.0))
    assert progress.completion(end) == pytest.approx(0.4)


def test_a_route_that_crosses_itself_is_followed_in_its_order():
    loop = lane([0, 40, 40, 20, 20], [0, 0, 20, 20, -40])
    progress = RouteProgress(route(loop, goal=loop.length))
    seen = [progress.observe(ego(x, y)).position for x, y in ((0, 0), (20, 0), (40, 0), (40, 20), (20, 20), (20, 0.5))]
    assert seen == sorted(seen)
    assert seen[1] == pytest.approx(20.0)
    assert seen[-1] == pytest.approx(99.5)
