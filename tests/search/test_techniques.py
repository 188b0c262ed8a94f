"""The techniques in a made-up world: deterministic, inside the space, and better than chance where they should be."""

from pathlib import Path

import pytest
import yaml

from roadmend.core.errors import InputError
from roadmend.search.attempt import CRASH
from roadmend.search.avfuzzer import AvFuzzerParameters
from roadmend.search.behavexplor import LeaderClusters
from roadmend.search.evaluation import CRASH_FITNESS, Evaluation, Trial
from roadmend.search.registry import TECHNIQUES, make_technique, read_technique_parameters

from .toy import SPACE, drive, made_up, toy_evaluation

CONFIG = Path(__file__).parents[2] / "config" / "search"


# The toy has one valley and little behaviour to tell apart, so what pays there is to follow the nearest misses.
GREEDY = {"diversity_weight": 0.3, "violation_weight": 8.0, "violation_scale": 1.5, "rate": 0.05}


def violations(name, seed, budget=400):
    parameters = read_technique_parameters(name, GREEDY if name == "behavexplor" else {})
    technique = make_technique(name, SPACE, seed, parameters)
    return sum(trial.evaluation.is_violation for trial in drive(technique, budget))


@pytest.mark.parametrize("name", TECHNIQUES)
def test_the_seed_decides_everything(name):
    first, same, other = (drive(make_technique(name, SPACE, seed), 150) for seed in (1, 1, 2))
    assert first == same
    assert first != other


@pytest.mark.parametrize("name", TECHNIQUES)
def test_points_lie_in_the_space(name):
    for trial in drive(make_technique(name, SPACE, 3), 300):
        assert all(SPACE[key].contains(trial.parameters[key]) for key in SPACE)


@pytest.mark.parametrize("name", ["avfuzzer", "behavexplor"])
def test_guided_search_beats_chance(name):
    seeds = range(5)
    guided = sum(violations(name, seed) for seed in seeds)
    assert guided > 3 * sum(violations("random", seed) for seed in seeds)
    assert guided > 20


def test_avfuzzer_restarts_away_from_where_it_was():
    technique = make_technique("avfuzzer", SPACE, 1, AvFuzzerParameters(patience=1, population=4))
    drive(technique, 300)
    assert technique.restarts > 2
    assert len(technique._left) == technique.restarts


def test_behavexplor_meets_more_behaviour_than_it_keeps_alike():
    technique = make_technique("behavexplor", SPACE, 1)
    drive(technique, 200)
    assert len(technique._clusters) > 3
    assert all(seed.fitness < 0.0 for seed in technique._corpus)  # violations are found, not followed


@pytest.mark.parametrize("name", TECHNIQUES)
@pytest.mark.parametrize("outcome", ["COLLISION", CRASH])
def test_a_world_where_all_is_alike_stops_nobody(name, outcome):
    crash = Evaluation(None, "broken", CRASH_FITNESS, (0.0, 0.0))
    technique = make_technique(name, SPACE, 1)
    for _ in range(15):
        points = technique.propose()
        assert points
        technique.learn(
            [
                Trial(
                    point,
                    crash if outcome == CRASH else made_up(outcome, "d", 0.0, (0.0, 0.0)),
                )
                for point in points
            ]
        )


def test_clusters_gather_what_is_alike():
    clusters = LeaderClusters(1.0)
    assert clusters.nearest([0.0, 0.0]) == (-1, float("inf"))
    assert clusters.add([0.0, 0.0]) == (0, 1.0)
    assert clusters.add([0.5, 0.5]) == (0, 0.5)
    assert clusters.nearest([0.25, 0.25]) == (0, 0.0)  # the centre has followed
    assert clusters.add([5.0, 5.0]) == (1, 1.0)
    assert clusters.counts == [2, 1]


@pytest.mark.parametrize("name", TECHNIQUES)
def test_the_shipped_file_says_the_defaults(name):
    values = yaml.safe_load((CONFIG / f"{name}.yaml").read_text())
    assert values == TECHNIQUES[name].parameters().model_dump()


@pytest.mark.parametrize(
    "values", [{"population": 1}, {"popluation": 9}, {"promising": float("nan")}, {"local_size": "6"}]
)
def test_bad_parameters_are_refused(values):
    with pytest.raises(InputError, match=next(iter(values))):
        read_technique_parameters("avfuzzer", values)


def test_an_unknown_technique_is_refused():
    with pytest.raises(InputError, match="choose one of random"):
        make_technique("guess", SPACE, 1)


def test_the_toy_is_hard_enough():
    trials = drive(make_technique("random", SPACE, 9), 400)
    assert toy_evaluation(trials[0].parameters) == trials[0].evaluation
    assert sum(trial.evaluation.is_violation for trial in trials) < 20
