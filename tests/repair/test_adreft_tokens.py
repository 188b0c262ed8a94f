"""Tokens of every tokenizer: one for each participant at least, and the same wherever the scene lies on the map."""

import math
from dataclasses import replace
from random import Random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from roadmend.core.command import Decision, Trajectory
from roadmend.core.errors import InputError
from roadmend.core.geometry import wrap_angle
from roadmend.core.route import Route, Stage
from roadmend.core.scene import EgoState
from roadmend.repair.adreft.registry import TOKENIZERS, make_tokenizer

from .playground import Box, ego_at, keep_on, scene_of, straight_route


def draw_boxes(numbers, count):
    return [
        Box(
            index + 1,
            numbers.uniform(-60, 90),
            numbers.uniform(-30, 30),
            numbers.uniform(-3, 3),
            numbers.uniform(0, 15),
            numbers.uniform(-4, 2),
            numbers.uniform(-0.4, 0.4),
            numbers.uniform(1, 12),
            numbers.uniform(0.5, 2.5),
        )
        for index in range(count)
    ]


def moved(x, y, yaw, by):
    """A pose after a motion (dx, dy, turn) of the whole map."""
    dx, dy, turn = by
    cosine, sine = math.cos(turn), math.sin(turn)
    return cosine * x - sine * y + dx, sine * x + cosine * y + dy, yaw + turn


def moved_route(route, by):
    stages = tuple(Stage(*moved(stage.x, stage.y, 0.0, by)[:2], stage.speed_limit) for stage in route.stages)
    return Route(route.scenario, route.ego_length, route.ego_width, route.goal, route.time_limit, stages, (), ())


def moved_scene(scene, by):
    ego, objects = scene.ego, scene.objects
    x, y, yaw = moved(ego.x, ego.y, ego.yaw, by)
    pose = dict(zip(("x", "y", "yaw"), moved(objects.x, objects.y, objects.yaw, by), strict=True))
    new = EgoState.from_yaw(x, y, wrap_angle(yaw), ego.speed, ego.yaw_rate, ego.length, ego.width)
    return replace(scene, ego=new, objects=objects.with_columns(**pose))


def moved_decision(decision, by):
    plan = decision.trajectory
    x, y, yaw = moved(plan.x, plan.y, plan.yaw, by)
    return Decision(decision.command, Trajectory(plan.interval, x, y, yaw, plan.speed))


@pytest.mark.parametrize("name", TOKENIZERS)
@settings(max_examples=30, deadline=None)
@given(
    seed=st.integers(0, 10**6),
    by=st.tuples(st.floats(-300, 300), st.floats(-300, 300), st.floats(-3.1, 3.1)),
    count=st.integers(0, 12),
)
def test_tokens_do_not_depend_on_where_the_scene_lies(name, seed, by, count):
    scene = scene_of(draw_boxes(Random(seed), count), ego=ego_at(speed=8.0))
    decision = keep_on(scene)
    tokenizer, other = make_tokenizer(name), make_tokenizer(name)
    tokenizer.reset(straight_route())
    other.reset(moved_route(straight_route(), by))
    here, there = tokenizer.tokens(scene, decision), other.tokens(moved_scene(scene, by), moved_decision(decision, by))
    np.testing.assert_array_equal(here.object_rows, there.object_rows)
    np.testing.assert_allclose(here.values, there.values, atol=2e-4)


@pytest.mark.parametrize("name", TOKENIZERS)
@pytest.mark.parametrize("count", [0, 1, 20, 300])
def test_no_participant_is_left_out(name, count):
    tokenizer = make_tokenizer(name)
    assert tokenizer.name == name
    tokenizer.reset(straight_route())
    scene = scene_of(draw_boxes(Random(count), count))
    for decision in (keep_on(scene), replace(keep_on(scene), trajectory=Trajectory.empty())):
        tokens = tokenizer.tokens(scene, decision)
        assert tokens.values.dtype == np.float32
        assert tokens.values.shape == (len(tokens), tokenizer.attributes)
        assert np.isfinite(tokens.values).all()
        assert set(range(count)) <= set(tokens.object_rows.tolist()) <= set(range(-1, count))


@pytest.mark.parametrize("name", TOKENIZERS)
def test_a_reset_forgets(name):
    scenes = [scene_of([Box(1, 40.0 - tick, 3.0, speed=4.0)], 0.05 * tick) for tick in range(6)]
    tokenizer = make_tokenizer(name)

    def run():
        tokenizer.reset(straight_route())
        return [tokenizer.tokens(scene, keep_on(scene)).values for scene in scenes]

    first = [values.copy() for values in run()]
    for one, other in zip(first, run(), strict=True):
        np.testing.assert_array_equal(one, other)


def test_the_papers_six_attributes():
    scene = scene_of([Box(7, 30.0, 5.0, yaw=math.pi, length=10.0, width=2.5)], ego=ego_at(10.0, 5.0, 0.5 * math.pi))
    tokenizer = make_tokenizer("paper")
    tokens = tokenizer.tokens(scene, keep_on(scene, points=2, speed=20.0))
    one, point, last = tokens.values
    np.testing.assert_allclose(one, [1.0, 0.0, -1.0, 0.5, 0.5, 2.0], atol=1e-6)  # 20 m to the right, heading left
    np.testing.assert_allclose(point, [2.0, 0.1, 0.0, 0.0, 0.36, 0.9], atol=1e-6)
    np.testing.assert_allclose(last, [2.0, 0.2, 0.0, 0.0, 0.36, 0.9], atol=1e-6)
    assert tokens.object_rows.tolist() == [0, -1, -1]


def test_an_unknown_tokenizer_is_refused_with_the_known_ones():
    with pytest.raises(InputError, match=r"no 'words'.*paper"):
        make_tokenizer("words")


def test_an_absurd_plan_cannot_swamp_the_rich_tokens():
    scene = scene_of(draw_boxes(Random(1), 5))
    plan = keep_on(scene).trajectory
    tokenizer = make_tokenizer("rich")
    tokenizer.reset(straight_route())
    for worth in (1e300, -1e300, 1e7):
        absurd = Trajectory(plan.interval, plan.x + worth, plan.y, plan.yaw, plan.speed + abs(worth))
        values = tokenizer.tokens(scene, Decision(keep_on(scene).command, absurd)).values
        assert np.isfinite(values).all()
        assert np.abs(values).max() <= 12.0
