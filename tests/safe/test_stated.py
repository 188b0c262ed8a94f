"""What a report says of its roads is built as said, and no longer drawn."""

import random
from dataclasses import replace

import pytest

from roadmend.safe.layout import lay_out
from roadmend.safe.open_questions import answer, open_questions
from roadmend.safe.stated import bend_side, control_of, lanes_of, main_heading, median_of
from roadmend.world.network import network_file
from roadmend.world.road_network import read_network
from roadmend.world.space import sample

from .crashes import ALL, crash, vehicle


def layout_of(what, seed=3):
    drawn = sample(open_questions(what), random.Random(seed))
    return lay_out(answer(what, drawn), drawn)


@pytest.mark.parametrize("side", ["left", "right"])
def test_a_bend_goes_to_the_side_that_is_told(side):
    told = replace(ALL["curve"], extras={"x-bend": side})
    assert "bend" not in open_questions(told)
    assert {layout_of(told, seed).network.bend > 0.0 for seed in range(6)} == {side == "left"}


def test_a_median_lies_between_the_directions():
    told = replace(crash("Straight", vehicle("W2E"), vehicle("E2W"), lanes=4), extras={"x-median": 12})
    layout = layout_of(told)
    net = read_network(network_file(layout.network))
    inner = [net.edges[name].car_lanes[-1].shape[0, 1] for name in ("forward", "backward")]
    assert inner[1] - inner[0] == pytest.approx(12.0 + 3.2, abs=0.05)
    assert layout.median == 12.0
    assert median_of(replace(told, extras={"x-divided": True})) > 0.0
    assert median_of(crash("Straight", vehicle())) == 0.0


@pytest.mark.parametrize(
    ("told", "built"),
    [
        ("signal", "traffic_light"),
        ("stop sign", "priority_stop"),
        ("all-way stop", "allway_stop"),
        ("none", "right_before_left"),
    ],
)
def test_a_junction_is_controlled_as_told(told, built):
    what = replace(ALL["intersection"], extras={"x-control": told})
    assert {layout_of(what, seed).network.control for seed in range(4)} == {built}


def test_the_stop_sign_of_a_tee_stands_at_its_stem():
    tee = replace(ALL["tee"], extras={"x-control": "stop sign"})
    assert [arm.name for arm in layout_of(tee).network.arms if not arm.major] == ["east"]


def test_vehicles_start_on_the_lanes_that_are_told():
    lanes = ("left", "middle", "right", 2, None, "up")
    what = crash("Straight", *(replace(vehicle(), extras={} if told is None else {"x-lane": told}) for told in lanes))
    assert lanes_of(what) == {0: 99, 1: 1, 2: 0, 3: 1}


def test_a_merging_leads_where_it_is_told():
    what = replace(ALL["merging"], extras={"x-heading": "North"})
    layout = layout_of(what)
    shape = read_network(network_file(layout.network)).edges["mainline"].car_lanes[0].shape
    assert shape[-1, 1] - shape[0, 1] > 100.0
    assert layout.ways[0].heading == 90.0


def test_what_is_not_told_or_strange_is_none():
    nothing = crash("Straight", vehicle())
    strange = replace(nothing, extras={"x-bend": 7, "x-control": "police", "x-heading": "up", "x-median": "wide"})
    for what in (nothing, strange):
        assert (bend_side(what), control_of(what), main_heading(what), median_of(what)) == (None, None, None, 0.0)


def test_a_bend_is_as_wide_as_its_speed_limit_asks():
    slow = layout_of(crash("Curve", vehicle("N2S", limit=25), vehicle("S2N", limit=25)))
    fast = layout_of(crash("Curve", vehicle("N2S", limit=60), vehicle("S2N", limit=60)))
    assert fast.network.radius > 250.0 > slow.network.radius


def test_a_traffic_light_may_begin_anywhere_in_its_cycle():
    what = replace(ALL["intersection"], extras={"x-control": "signal"})
    offsets = set()
    for seed in range(12):
        network = layout_of(what, seed).network
        text = network_file(network).read_text(encoding="utf-8")
        offsets.add((network.phase, 'offset="-20"' in text))
    assert offsets == {(0.0, False), (20.0, True)}
