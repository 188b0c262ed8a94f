"""Descriptors of real scenarios, and of those that are drawn without building any."""

import dataclasses
from collections import Counter
from pathlib import Path

import pytest

from harness.generated import generate
from roadmend.sera.describe import describe, entry_of_case
from roadmend.sera.descriptor import Hazard, OutcomeStatistics
from roadmend.sera.terms import features
from roadmend.sera.words import words_of
from roadmend.world.corpus import load_corpus
from roadmend.world.families import sample_scenario
from roadmend.world.scenario import Ego, Scenario
from roadmend.world.scenario_actors import Pedestrian, Vehicle
from roadmend.world.scenario_file import load_scenario
from roadmend.world.scenario_networks import Arm, IntersectionNetwork, NetworkFile

CONFIG = Path(__file__).parents[2] / "config"


def intersection(out="west_out", **vehicle):
    bearings = {"south": -90.0, "east": 0.0, "north": 90.0, "west": 180.0}
    arms = [Arm(name=name, bearing=bearing, lanes=2) for name, bearing in bearings.items()]
    actor = Vehicle.model_validate({"id": "v0", "route": ["north_in", "south_out"], **vehicle})
    ego = Ego(route=["south_in", out], lane=1, position=50.0)
    return Scenario(name="x", network=IntersectionNetwork(arms=arms), ego=ego, actors=[actor])


@pytest.mark.parametrize(
    ("out", "manoeuvre"), [("west_out", "left_turn"), ("east_out", "right_turn"), ("north_out", "straight")]
)
def test_the_task_is_read_off_the_route(out, manoeuvre):
    assert describe(intersection(out)).manoeuvre == manoeuvre


RUN = {"action": "run", "when": {"time": 1.0}}
BRAKE = {"action": "brake", "when": {"ego_distance": 9.0}}
CUT_IN = {"action": "cut_in", "when": {"ego_distance": 12.0}, "direction": "ego"}


@pytest.mark.parametrize(
    ("vehicle", "hazard"),
    [
        ({"manoeuvres": [RUN]}, Hazard("run_right_of_way", "car", "oncoming")),
        ({"route": ["east_in", "west_out"], "manoeuvres": [RUN]}, Hazard("run_right_of_way", "car", "right")),
        ({"route": ["west_in", "east_out"], "manoeuvres": [RUN]}, Hazard("run_right_of_way", "car", "left")),
        (
            {"route": ["south_in", "east_out"], "lane": 1, "position": 70.0, "kind": "bus", "manoeuvres": [BRAKE]},
            Hazard("hard_braking", "bus", "ahead", 9.0),
        ),
        (
            {"route": ["south_in", "east_out"], "lane": 1, "position": 20.0, "manoeuvres": [BRAKE]},
            Hazard("hard_braking", "car", "behind", 9.0),
        ),
        (
            {"route": ["south_in", "east_out"], "lane": 0, "manoeuvres": [CUT_IN, BRAKE]},
            Hazard("cut_in_and_brake", "car", "right", 9.0),
        ),
    ],
)
def test_a_hazard_has_a_kind_a_participant_a_side_and_a_distance(vehicle, hazard):
    assert describe(intersection(**vehicle)).hazards == (hazard,)


def test_a_vehicle_without_manoeuvre_is_no_hazard_and_a_crossing_pedestrian_is_one():
    scenario = intersection()
    assert describe(scenario).hazards == ()
    walker = Pedestrian(id="p0", route=["east_in", "south_out"])
    crossing = scenario.model_copy(update={"actors": [walker]})
    assert describe(crossing).hazards == (Hazard("pedestrian_crossing", "pedestrian", "right"),)
    staying = walker.model_copy(update={"route": ["east_in", "east_out"]})
    assert describe(scenario.model_copy(update={"actors": [staying]})).hazards == ()


def test_of_a_network_of_the_users_own_it_tells_what_can_be_told():
    ego = Ego(route=["a", "b"])
    near = Vehicle(id="v0", route=["a", "b"], lane=1, manoeuvres=[CUT_IN])
    far = Vehicle(id="v1", route=["c", "b"], manoeuvres=[CUT_IN])
    scenario = Scenario(name="own", network=NetworkFile(path="x.net.xml"), ego=ego, actors=[near, far])
    found = describe(scenario)
    assert (found.road.kind, found.manoeuvre, found.family) == ("road_network", None, None)
    assert [each.side for each in found.hazards] == ["left", None]


def test_words_say_what_the_structure_says():
    text = words_of(describe(load_scenario(CONFIG / "scenarios" / "demo-merge.yaml")))
    for words in ("on-ramp", "2 lanes, 80 km/h", "the ego merges", "dense traffic", "rain by day"):
        assert words in text
    assert "2 x motorcycle from the left cuts in, truck from behind cuts in" in text


def test_a_case_brings_its_outcome_along():
    corpus = load_corpus(CONFIG / "corpora" / "modular.jsonl")
    case = corpus.select("S5", "test", violation=True)[0]
    found = entry_of_case(case, corpus)
    assert found.descriptor.outcomes == (OutcomeStatistics("modular", {"COLLISION": 1}, case.min_distance),)
    assert found.digest == case.scenario().digest


def test_drawn_descriptors_are_spread_as_those_of_scenarios():
    count = 120
    real = [
        describe(sample_scenario(family, seed)) for family in ("S1", "S2", "S3", "S4", "S5") for seed in range(count)
    ]
    drawn = [each.descriptor for each in generate(2500, 1)]
    shares = []
    for descriptors in (real, drawn):
        found = Counter(term for each in descriptors for term in features(dataclasses.replace(each, outcomes=())).terms)
        shares.append({term: number / len(descriptors) for term, number in found.items()})
    for term in shares[0].keys() | shares[1].keys():
        assert shares[0].get(term, 0.0) == pytest.approx(shares[1].get(term, 0.0), abs=0.1), term


def test_the_same_seed_draws_the_same():
    assert list(generate(30, 4)) == list(generate(30, 4))
    assert list(generate(30, 4)) != list(generate(30, 5))
