import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from roadmend.core.command import Command, Decision, Trajectory
from roadmend.repair.state_vector import PER_OBJECT, SIZE, K, state_vector

from .playground import Box, ego_at, scene_of

FIRST = SIZE - K * PER_OBJECT
BARE = Decision(Command(0.0, 0.0), Trajectory.empty())


def rows_of(vector):
    return vector[FIRST:].reshape(K, PER_OBJECT)


def test_the_nearest_come_first_and_the_missing_are_zeros():
    scene = scene_of([Box(1, 40.0, 0.0), Box(2, 8.0, 4.0, speed=15.0), Box(3, -20.0, 0.0)])
    rows = rows_of(state_vector(scene, BARE))
    assert rows[:, 0].tolist() == [1.0] * 3 + [0.0] * 5
    assert (40.0 * rows[:3, 1]).tolist() == pytest.approx([8.0, -20.0, 40.0])
    assert (40.0 * rows[:3, 2]).tolist() == pytest.approx([4.0, 0.0, 0.0])
    assert (15.0 * rows[:3, 5]).tolist() == pytest.approx([15.0 - scene.ego.speed, -scene.ego.speed, -scene.ego.speed])
    assert not rows[3:].any()


def test_beyond_the_last_place_nobody_is_seen():
    boxes = [Box(number, 10.0 + number, 0.0) for number in range(12)]
    rows = rows_of(state_vector(scene_of(boxes), BARE))
    assert (40.0 * rows[:, 1]).tolist() == pytest.approx([10.0 + number for number in range(K)], rel=1e-6)


def test_the_plan_is_read_at_its_times():
    x = 2.0 * np.arange(1.0, 8.0)  # 0.5 s apart at 4 m/s
    plan = Trajectory(0.5, x, np.zeros(7), np.zeros(7), np.full(7, 4.0))
    scene = scene_of([])
    vector = state_vector(scene, Decision(Command(0.0, 0.0), plan))
    here = scene.ego.x
    assert (40.0 * vector[3:9:2]).tolist() == pytest.approx([4.0 - here, 8.0 - here, 12.0 - here], abs=1e-5)
    assert vector[2] == 1.0
    assert state_vector(scene, BARE)[2:9].tolist() == [0.0] * 7


@given(st.floats(-math.pi, math.pi), st.floats(-500.0, 500.0), st.floats(-500.0, 500.0))
def test_it_does_not_depend_on_where_the_scene_lies(turn, dx, dy):
    boxes = [Box(1, 12.0, 3.0, 0.4, speed=6.0), Box(2, -7.0, -3.5, 2.0, speed=2.0)]
    cosine, sine = math.cos(turn), math.sin(turn)

    def moved(box):
        x, y = box.x * cosine - box.y * sine + dx, box.x * sine + box.y * cosine + dy
        return Box(box.id, x, y, box.yaw + turn, speed=box.speed)

    before = state_vector(scene_of(boxes, ego=ego_at(0.0)), BARE)
    ego = ego_at(dx, dy, turn)
    assert state_vector(scene_of([moved(box) for box in boxes], ego=ego), BARE) == pytest.approx(before, abs=1e-4)
