"""The guard against forgetting, and weights part of the way."""

from dataclasses import replace

import numpy as np
import pytest

from roadmend.measures.driving import DrivingMeasures
from roadmend.training.tuning_guard import TunedCandidate, TuningGuard, TuningTrial, mixture
from roadmend.world.families import sample_scenario

GOOD = DrivingMeasures("GOAL", 100.0, (), 100.0, True, None, None, False)
BAD = replace(GOOD, outcome="COLLISION", driving_score=30.0, success=False)


@pytest.fixture
def guard():
    scenarios = [sample_scenario("S1", seed) for seed in range(4)]
    guard = TuningGuard(scenarios[:3], scenarios[3:], tolerance=1.0)
    assert guard.first([BAD], [GOOD, GOOD, BAD]) == TuningTrial(0, 30.0, pytest.approx(230.0 / 3.0))
    return guard


def scored(score, number=1):
    return TunedCandidate(TuningTrial(number, score, None), {})


def test_candidates_that_are_better_on_the_hard_ones_are_ranked(guard):
    found = guard.ranked([scored(50.0, 1), scored(30.0, 2), scored(90.0, 3), scored(50.0, 4), scored(10.0, 5)])
    assert [candidate.trial.epochs for candidate in found] == [3, 1, 4]
    assert guard.trial(2, [GOOD, BAD], 0.5, 0.25) == TuningTrial(2, 65.0, None, 0.5, 0.25)


@pytest.mark.parametrize(
    ("ordinary", "is_allowed"),
    [
        ([GOOD, GOOD, BAD], True),
        ([GOOD, GOOD, GOOD], True),
        ([GOOD, BAD, GOOD], True),  # it fails in another one
        ([GOOD, BAD, BAD], False),
        ([GOOD, replace(GOOD, driving_score=96.0), BAD], False),  # 1.3 lost
        ([GOOD, replace(GOOD, driving_score=98.5), BAD], True),  # 0.5 lost
    ],
)
def test_a_trial_may_lose_nothing_on_ordinary_scenarios(guard, ordinary, is_allowed):
    assert guard.allows(guard.judged(scored(90.0), ordinary).trial) is is_allowed


def test_a_trial_that_was_not_judged_is_not_allowed(guard):
    assert not guard.allows(scored(90.0).trial)


@pytest.mark.parametrize(("share", "between"), [(0.0, 1.0), (0.25, 1.5), (1.0, 3.0)])
def test_a_mixture_lies_between_the_weights(share, between):
    old, new = {"a": np.full((2, 3), 1.0, dtype=np.float32)}, {"a": np.full((2, 3), 3.0, dtype=np.float32)}
    mixed = mixture(old, new, share)
    assert mixed["a"].dtype == np.float32
    np.testing.assert_array_equal(mixed["a"], np.full((2, 3), between, dtype=np.float32))
