"""Moves stay in the space, move something and keep participants whole."""

import random

import pytest

from roadmend.search.moves import cross, distance, mutate
from roadmend.world.families import FAMILIES
from roadmend.world.space import Choice, Uniform, sample

from .toy import SPACE


def lies_in(space, parameters):
    return list(parameters) == list(space) and all(space[name].contains(parameters[name]) for name in space)


@pytest.mark.parametrize("family", ["toy", *FAMILIES])
@pytest.mark.parametrize("strength", [0.01, 0.3, 1.0])
def test_mutants_and_children_lie_in_the_space(family, strength):
    space = SPACE if family == "toy" else FAMILIES[family].space
    generator = random.Random(5)
    point, other = sample(space, generator), sample(space, generator)
    for rate in (0.05, 1.0):
        for _ in range(20):
            point = mutate(space, point, rate, strength, generator)
            assert lies_in(space, point)
            assert lies_in(space, cross(space, point, other, generator))


@pytest.mark.parametrize(("low", "high"), [(0.12345, 0.98765), (1.0, 1.0), (-0.0004, 0.0004)])
def test_rounding_does_not_leave_the_range(low, high):
    space = {"x": Uniform(low, high)}
    generator = random.Random(1)
    for _ in range(200):
        assert lies_in(space, mutate(space, {"x": low}, 1.0, 0.5, generator))


@pytest.mark.parametrize(("value", "allowed"), [("x", {"x"}), ("y", {"x"})])
def test_what_has_no_weight_is_not_moved_to(value, allowed):
    space, generator = {"a": Choice({"x": 1.0, "y": 0.0})}, random.Random(1)
    assert {mutate(space, {"a": value}, 1.0, 0.5, generator)["a"] for _ in range(20)} == allowed


def test_at_least_one_dimension_is_moved():
    space = {name: dimension for name, dimension in SPACE.items() if name not in ("only", "fixed")}
    generator = random.Random(2)
    point = sample(space, generator)
    moved = [mutate(space, point, 1e-9, 0.3, generator) for _ in range(50)]
    assert all(sum(point[name] != new[name] for name in space) == 1 for new in moved)


def test_a_mutation_leaves_its_argument_alone():
    generator = random.Random(3)
    point = sample(SPACE, generator)
    before = dict(point)
    mutate(SPACE, point, 1.0, 1.0, generator)
    assert point == before


def test_a_participant_comes_whole_from_one_parent():
    generator = random.Random(4)
    first, second = sample(SPACE, generator), sample(SPACE, generator)
    parents = set()
    for _ in range(30):
        child = cross(SPACE, first, second, generator)
        for slot in range(4):
            whole = [{name: parent[name] for name in (f"v{slot}.x", f"v{slot}.y")} for parent in (first, second)]
            assert {name: child[name] for name in whole[0]} in whole
        parents.add((child["v0.x"] == first["v0.x"], child["v1.x"] == first["v1.x"]))
    assert len(parents) == 4


def test_distance_is_zero_for_the_same_and_at_most_one():
    space = {"x": Uniform(0.0, 2.0), "kind": SPACE["kind"], "only": SPACE["only"]}
    assert distance(space, {"x": 1.0, "kind": "car", "only": 2}, {"x": 1.0, "kind": "car", "only": 2}) == 0.0
    assert distance(space, {"x": 0.0, "kind": "car", "only": 2}, {"x": 2.0, "kind": "bus", "only": 2}) == pytest.approx(
        2 / 3
    )
