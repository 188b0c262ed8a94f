import math

import numpy as np
import pytest

from roadmend.core.command import Trajectory
from roadmend.repair.conflict import shared_ground, way_coordinates
from roadmend.repair.planned_path import PathFinder

from .playground import Box, ego_at, object_list, straight_route


@pytest.mark.parametrize("yaw", [-2.0, 0.0, 0.7, 3.0])
@pytest.mark.parametrize("yaw_rate", [-0.5, -0.2, 0.2, 0.5])
@pytest.mark.parametrize("aside", [-2.0, 0.0, 1.5])
def test_points_beside_a_turning_way_have_its_distance_and_offset(yaw, yaw_rate, aside):
    x, y, heading, speed = 3.0, -7.0, yaw, 8.0
    for step in range(1, 2001):
        x += speed * 1e-3 * math.cos(heading + 5e-4 * yaw_rate)
        y += speed * 1e-3 * math.sin(heading + 5e-4 * yaw_rate)
        heading += yaw_rate * 1e-3
        if step % 500 == 0:
            px, py = x - aside * math.sin(heading), y + aside * math.cos(heading)
            along, offset, found = way_coordinates(px, py, 3.0, -7.0, yaw, speed, yaw_rate)
            assert along == pytest.approx(speed * step * 1e-3, abs=1e-3)
            assert offset == pytest.approx(aside, abs=1e-3)
            assert math.cos(found - heading) == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("yaw_rate", [-0.3, 0.0, 0.3])
def test_points_behind_are_at_negative_distances(yaw_rate):
    assert way_coordinates(-2.0, 0.0, 0.0, 0.0, 0.0, 8.0, yaw_rate)[0] == pytest.approx(-2.0, abs=0.02)


def share(x, y, yaw, speed=8.0, ahead=50.0):
    finder = PathFinder()
    finder.reset(straight_route())
    path = finder.find(ego_at(), Trajectory.empty(), 60.0)
    other = object_list([Box(1, x, y, yaw, speed)]).table[0]
    return shared_ground(path, other, 1.8, 4.0, ahead)


def test_a_crossing_way_shares_as_much_as_both_are_wide():
    begin, end, least, greatest, turned = share(30.0, -20.0, 0.5 * math.pi)
    assert begin == pytest.approx(28.2, abs=1.5)
    assert end == pytest.approx(31.8, abs=1.5)
    assert least == pytest.approx(20.0)
    assert greatest == pytest.approx(20.0)
    assert turned == pytest.approx(0.5 * math.pi)


@pytest.mark.parametrize(
    ("y", "yaw"), [(-20.0, -0.5 * math.pi), (-60.0, 0.5 * math.pi), (5.0, 0.0), (8.0, 0.5 * math.pi)]
)
def test_ways_that_lead_elsewhere_share_nothing(y, yaw):
    assert share(30.0, y, yaw)[0] == math.inf


def test_only_ground_ahead_of_the_ego_counts():
    assert share(-20.0, -20.0, 0.5 * math.pi)[0] == math.inf
    assert np.isclose(share(0.0, -20.0, 0.5 * math.pi)[0], 0.0)
