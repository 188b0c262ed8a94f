"""What the neural policy sees."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from roadmend.core.route import RightOfWay
from roadmend.core.scene import Signal
from roadmend.policies.neural_observer import Observer
from roadmend.policies.neural_tokens import COLUMNS, OBJECTS, PLACES, TOKENS

from .proving_ground import Body, road, scene_at, two_lanes, walker, zone

KINDS = 4
numbers = st.floats(-1e6, 1e6) | st.sampled_from([0.0, math.nan, math.inf, -math.inf])


def tokens_of(route, scene):
    observer = Observer()
    observer.reset(route)
    return np.array(observer.observe(scene)), observer


def test_an_empty_road_is_the_ego_and_the_places():
    tokens, _ = tokens_of(road(), scene_at(0.0, 30.0, 10.0))
    assert tokens.shape == (1 + len(PLACES), COLUMNS)
    assert tokens[0, 0] == 1.0
    assert np.all(tokens[1:, 2] == 1.0)


def test_every_token_has_one_kind():
    light = road(zone(100.0, 110.0, RightOfWay.SIGNAL))
    bodies = [Body(1, 60.0, 0.0, speed=5.0), walker(2, 80.0, 5.0, 1.0, 1.0)]
    tokens, observer = tokens_of(light, scene_at(0.0, 30.0, 10.0, bodies, [Signal.RED]))
    assert np.all(tokens[:, :KINDS].sum(axis=1) == 1.0)
    assert tokens[:, 1].sum() == 2
    assert tokens[:, 3].sum() == 1
    assert sorted(observer.objects[observer.objects >= 0]) == [0, 1]


def test_the_colour_of_the_light_and_the_lane_change_are_seen():
    light = road(zone(100.0, 110.0, RightOfWay.SIGNAL))
    red, _ = tokens_of(light, scene_at(0.0, 60.0, 10.0, (), [Signal.RED]))
    green, _ = tokens_of(light, scene_at(0.0, 60.0, 10.0, (), [Signal.GREEN]))
    assert not np.array_equal(red, green)
    _, before = tokens_of(two_lanes(), scene_at(0.0, 30.0, 10.0))
    _, inside = tokens_of(two_lanes(), scene_at(0.0, 90.0, 10.0))
    assert not before.may_change
    assert inside.may_change
    inside.begin_change()
    inside.observe(scene_at(0.05, 90.5, 10.0))
    assert not inside.may_change


def test_of_many_objects_the_nearest_in_the_way_come_first():
    bodies = [Body(number, 60.0 + 2.0 * number, -12.0, speed=3.0) for number in range(30)]
    bodies.append(Body(99, 45.0, 0.0, speed=3.0))
    tokens, observer = tokens_of(road(), scene_at(0.0, 30.0, 10.0, bodies))
    assert len(tokens) <= TOKENS
    assert tokens[:, 1].sum() == OBJECTS
    assert observer.objects[tokens[:, 1].argmax()] == 30


@settings(max_examples=60, deadline=None)
@given(values=st.lists(st.tuples(numbers, numbers, numbers, numbers), max_size=5), speed=st.floats(0.0, 60.0))
def test_tokens_are_finite_whatever_is_seen(values, speed):
    bodies = [Body(number, x, y, yaw, v) for number, (x, y, yaw, v) in enumerate(values)]
    tokens, _ = tokens_of(two_lanes(), scene_at(0.0, 60.0, speed, bodies))
    assert np.isfinite(tokens).all()
    assert np.abs(tokens).max() < 20.0


@pytest.mark.parametrize("action", [-1.0, -0.2, 0.0, 0.4, 1.0])
def test_the_trajectory_is_where_the_action_leads(action):
    _, observer = tokens_of(road(), scene_at(0.0, 30.0, 8.0))
    plan = observer.trajectory(action, "drive")
    steps = np.hypot(np.diff(plan.x), np.diff(plan.y))
    assert np.all(steps <= np.maximum(plan.speed[:-1], plan.speed[1:]) * plan.interval + 1e-6)
    assert np.all(plan.speed >= 0.0)
    assert np.all(plan.speed <= 14.5)
    assert (plan.speed[-1] > 8.0) == (action > 0.1)


def test_an_unusable_ego_has_no_tokens():
    observer = Observer()
    assert observer.observe(scene_at(0.0, 30.0, 8.0)) is None
    observer.reset(road())
    assert observer.observe(scene_at(0.0, math.nan, 8.0)) is None
