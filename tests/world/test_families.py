"""The families: what is drawn lies in its space and stands on its road."""

import itertools
import random
from collections import Counter
from functools import cache

import numpy as np
import pytest

from roadmend.core.errors import InputError
from roadmend.world.drivers import BODIES
from roadmend.world.families import FAMILIES, sample_scenario
from roadmend.world.families.intersection import _ARM_LENGTH, _JUNCTION_RADIUS
from roadmend.world.families.traffic import LanePlace, make_room
from roadmend.world.network import network_file
from roadmend.world.road_network import read_network
from roadmend.world.route_builder import build_route
from roadmend.world.space import Choice, Uniform, Whole, sample
from roadmend.world.traffic_file import traffic_xml

COUNT = 300  # scenarios of each family
CROSSINGS = ("S1", "S2", "S3")
BUSY = (*CROSSINGS, "S4", "S5")  # with the traffic of the evaluation; any other may be as empty as it likes
_JOINT = 10.0  # [m] at most that netconvert cuts off where a ramp meets a highway


@cache
def drawn(family):
    return [sample_scenario(family, seed) for seed in range(COUNT)]


def edge_length(scenario, edge):
    """Length [m] that an edge has for certain, whatever netconvert cuts off at the junction."""
    network = scenario.network
    if scenario.family in CROSSINGS:
        return _ARM_LENGTH - _JUNCTION_RADIUS
    return {"approach": network.approach_length, "ramp": network.ramp_length}[edge] - _JOINT


def lanes(scenario, edge):
    network = scenario.network
    if scenario.family in CROSSINGS:
        return next(arm.lanes for arm in network.arms if edge == f"{arm.name}_in")
    return 1 if edge == "ramp" else network.lanes


@pytest.mark.parametrize("family", FAMILIES)
def test_every_sampled_parameter_lies_in_its_space(family):
    space = FAMILIES[family].space
    for seed in range(COUNT):
        parameters = sample(space, random.Random(seed))
        assert parameters.keys() == space.keys()
        outside = {name: value for name, value in parameters.items() if not space[name].contains(value)}
        assert outside == {}


@pytest.mark.parametrize(
    ("dimension", "inside", "outside"),
    [
        (Uniform(1.0, 2.0), (1.0, 1.5, 2.0, 2), (0.999, 2.001, "1.5")),
        (Whole(0, 2), (0, 1, 2), (-1, 3, 1.0)),
        (Choice({"a": 0.5, "b": 0.5}), ("a", "b"), ("c", "", 1)),
    ],
)
def test_a_dimension_knows_what_is_in_it(dimension, inside, outside):
    assert all(dimension.contains(value) for value in inside)
    assert not any(dimension.contains(value) for value in outside)
    assert all(dimension.contains(dimension.sample(random.Random(seed))) for seed in range(50))


@pytest.mark.parametrize("family", BUSY)
def test_everybody_starts_on_the_road(family):
    for scenario in drawn(family):
        ego = scenario.ego
        assert 0.5 * ego.length < ego.position < edge_length(scenario, ego.route[0]) - ego.length
        assert ego.lane < lanes(scenario, ego.route[0])
        for actor in scenario.actors:
            assert 0.0 <= actor.position <= edge_length(scenario, actor.route[0]), (scenario.name, actor.id)
            if actor.type == "vehicle":
                assert actor.position > BODIES[actor.kind].length  # all of it
                assert actor.lane < lanes(scenario, actor.route[0])


@pytest.mark.parametrize("family", FAMILIES)
def test_nobody_starts_inside_another(family):
    for scenario in drawn(family):
        ego = scenario.ego
        taken = {(ego.route[0], ego.lane): [(ego.position + 0.5 * ego.length, ego.length, "ego")]}
        for actor in scenario.actors:
            if actor.type == "vehicle" and actor.depart == 0.0:
                body = actor.position, BODIES[actor.kind].length, actor.id
                taken.setdefault((actor.route[0], actor.lane), []).append(body)
        for bodies in taken.values():
            bodies.sort()
            for (behind, _, name), (front, length, other) in itertools.pairwise(bodies):
                assert behind < front - length - 2.0, (scenario.name, name, other)


@pytest.mark.parametrize("family", BUSY)
def test_real_networks_carry_the_scenarios(family):
    """netconvert takes a tenth of a second for each, so this is a sample: the first, and the widest junctions."""
    wide = [scenario for scenario in drawn(family) if scenario.family in CROSSINGS and scenario.network.crossings]
    wide.sort(key=lambda scenario: -sum(arm.lanes for arm in scenario.network.arms))
    for scenario in drawn(family)[:3] + wide[:3]:
        network = read_network(network_file(scenario.network))
        traffic_xml(scenario, network)
        built = build_route(network, scenario)
        assert built.route.length > 50.0
        for edge in {scenario.ego.route[0], *(actor.route[0] for actor in scenario.actors)}:
            assert min(lane.length for lane in network.edges[edge].lanes) >= edge_length(scenario, edge)


@pytest.mark.parametrize("family", CROSSINGS)
def test_crossings_occur_with_every_shape_and_control(family):
    shapes = Counter(len(scenario.network.arms) for scenario in drawn(family))
    assert set(shapes) == {3, 4}
    assert 0.2 < shapes[3] / COUNT < 0.5
    controls = Counter(
        (scenario.network.control, scenario.network.arms[0].major)
        if scenario.network.control == "priority"
        else scenario.network.control
        for scenario in drawn(family)
    )
    assert set(controls) == {
        ("priority", True),
        ("priority", False),
        "right_before_left",
        "allway_stop",
        "traffic_light",
    }
    assert min(controls.values()) >= 0.04 * COUNT


@pytest.mark.parametrize("family", CROSSINGS)
def test_a_tee_misses_one_of_the_arms_that_the_ego_does_not_need(family):
    missing = Counter()
    for scenario in drawn(family):
        names = {arm.name for arm in scenario.network.arms}
        assert {"south", scenario.ego.route[-1].removesuffix("_out")} <= names
        missing.update({"south", "east", "north", "west"} - names)
        for actor in scenario.actors:
            assert {edge.rpartition("_")[0] for edge in actor.route} <= names
    assert len(missing) == 2
    assert min(missing.values()) > 0.05 * COUNT


@pytest.mark.parametrize("family", CROSSINGS)
def test_a_crossing_with_priority_has_one_main_road(family):
    for scenario in drawn(family):
        arms = scenario.network.arms
        if scenario.network.control == "priority":
            # Across a tee the ego may have to give way to the one arm that ends there.
            is_stem = family == "S3" and len(arms) == 3 and not arms[0].major
            assert sum(arm.major for arm in arms) == (1 if is_stem else 2), scenario.name


@pytest.mark.parametrize("family", BUSY)
def test_all_kinds_of_traffic_weather_and_misbehaviour_occur(family):
    scenarios = drawn(family)
    kinds = Counter(actor.kind for scenario in scenarios for actor in scenario.actors if actor.type == "vehicle")
    assert {"car", "truck", "bus", "motorcycle"} <= set(kinds)
    assert {scenario.environment.weather for scenario in scenarios} >= {"clear", "rainy", "foggy", "snowy"}
    assert {scenario.environment.time_of_day for scenario in scenarios} == {"daytime", "nighttime"}
    actions = {
        manoeuvre.action
        for scenario in scenarios
        for actor in scenario.actors
        if actor.type == "vehicle"
        for manoeuvre in actor.manoeuvres
    }
    assert actions == ({"brake", "run"} if family in CROSSINGS else {"brake", "cut_in"})
    sizes = sorted(len(scenario.actors) for scenario in scenarios)
    assert sizes[0] <= 8
    assert sizes[-1] >= 17


def test_room_is_made_ahead_and_behind_of_the_ego_without_overtaking():
    ego = LanePlace("ego", ("lane", 0), 100.0, 10.0, 4.7)
    crowd = [LanePlace(f"v{number}", ("lane", 0), 96.0 + number, 10.0, 5.0) for number in range(8)]
    elsewhere = LanePlace("w", ("lane", 1), 100.0, 10.0, 5.0)
    placed = sorted(make_room([*crowd, elsewhere], ego), key=lambda place: place.ahead)
    assert elsewhere in placed
    row = sorted([*(place for place in placed if place.lane == ego.lane), ego], key=lambda place: place.ahead)
    assert [place.slot for place in row] == ["v0", "v1", "v2", "v3", "ego", "v4", "v5", "v6", "v7"]
    for behind, front in itertools.pairwise(row):
        assert front.ahead - front.length - behind.ahead >= 3.0 + 0.6 * behind.speed - 1e-9


def test_a_seed_is_a_whole_number_and_numpys_will_do():
    assert sample_scenario("S3", np.int64(3)) == sample_scenario("S3", 3)
    for seed in (-1, 1.5, "x", None, True):
        with pytest.raises(InputError, match=r"^seed: .* is no whole number from 0; give for instance 7$"):
            sample_scenario("S3", seed)
    with pytest.raises(InputError, match=r"^seed: 2147483648 is beyond the last scenario of a family; stay up to"):
        sample_scenario("S3", 2**31)
