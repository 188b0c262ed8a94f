"""Points as text: exact both ways, and only what a scenario depends on."""

import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from roadmend.world.families import FAMILIES
from roadmend.world.point_text import dump_point, parse_point, used_parameters
from roadmend.world.space import Choice, Uniform, Whole, sample

SPACE = {"a": Uniform(0.0, 1.0), "b": Whole(1, 3), "c": Choice({8.33: 1.0, True: 1.0, "x,*y": 1.0}), "d": Whole(0, 9)}


@settings(max_examples=30, deadline=None)
@given(st.sampled_from([*FAMILIES]), st.integers(0, 10**9), st.floats(0.0, 1.0))
def test_a_point_comes_back_to_the_bit(name, seed, kept):
    generator = random.Random(seed)
    space = FAMILIES[name].space
    point = {key: value for key, value in sample(space, generator).items() if generator.random() <= kept}
    back = parse_point(space, dump_point(space, point))
    assert back == point
    assert [type(value) for value in back.values()] == [type(value) for value in point.values()]


@pytest.mark.parametrize("name", FAMILIES)
def test_what_is_used_gives_the_same_scenario(name):
    family = FAMILIES[name]
    for seed in range(20):
        point = sample(family.space, random.Random(seed))
        used = used_parameters(family.build, point, seed)
        assert family.build(used, "x", seed) == family.build(point, "x", seed)
        assert len(used) < len(point)
        other = sample(family.space, random.Random(seed + 1))
        changed = {key: other[key] for key in point if key not in used}
        assert family.build(point | changed, "x", seed) == family.build(point, "x", seed)


@pytest.mark.parametrize(
    ("read", "used"),
    [
        (lambda point: point["a"], "a"),
        (lambda point: point.get("a"), "a"),
        (lambda point: point.get("a", 0.5) if "b" in point else None, "ab"),
        (lambda point: point.pop("b"), "b"),
        (lambda point: dict(**point)["a"], "abcd"),
        (dict, "abcd"),
        (lambda point: point.copy(), "abcd"),
        (lambda point: point | {"a": 1.0}, "abcd"),
        (lambda point: [*point], "abcd"),
        (lambda point: [*point.values()], "abcd"),
        (lambda point: [*point.items()], "abcd"),
        (len, ""),
    ],
)
def test_what_a_family_reads_in_whatever_way_is_used(read, used):
    point = sample(SPACE, random.Random(1))
    before = dict(point)
    assert [*used_parameters(lambda given, _name, _seed: read(given), point, 1)] == [*used]
    assert point == before


def test_the_text_is_short():
    assert dump_point(SPACE, {"b": 2, "c": "x,*y"}) == ",2,2,"
    assert dump_point(SPACE, {"a": 0.1, "d": 9}) == "0.1,*2,9"
    assert dump_point(SPACE, {}) == "*4"


@pytest.mark.parametrize(
    "text",
    [
        "",
        "0.5",
        "0.5,2,0,1,1",
        "2.0,2,0,1",
        "nan,2,0,1",
        "0.5,4,0,1",
        "0.5,1.0,0,1",
        "0.5,2,3,1",
        "0.5,2,-1,1",
        "*3",
        "*x",
        "a,2,0,1",
    ],
)
def test_what_is_no_point_is_refused(text):
    with pytest.raises(ValueError):
        parse_point(SPACE, text)
