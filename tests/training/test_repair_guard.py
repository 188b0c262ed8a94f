"""The guard against forgetting, and weights part of the way."""

from dataclasses import replace

import numpy as np
import pytest

from roadmend.evaluation.driving_measures import DrivingMeasures
from roadmend.training.repair_guard import Guard, Trial, mixture
from roadmend.world.families import sample_scenario

GOOD = DrivingMeasures("GOAL", 100.0, (), 100.0, True, None, None, False)
WORSE = replace(GOOD, driving_score=97.0)
BAD = replace(GOOD, outcome="COLLISION", driving_score=30.0, success=False)


@pytest.fixture
def guard():
    scenarios = [sample_scenario("S1", seed) for seed in range(4)]
    return Guard(scenarios[:3], scenarios[3:], tolerance=1.0)


def test_only_ordinary_scenarios_that_went_well_before_are_watched(guard):
    first = guard.first([GOOD, GOOD, BAD, BAD])
    assert first == Trial(0, 65.0, 100.0)
    assert guard.trial(1, [GOOD, GOOD, GOOD, BAD], 0.5).ordinary == 100.0
    assert guard.trial(1, [GOOD, BAD, GOOD, BAD], 0.5).ordinary == 65.0


@pytest.mark.parametrize(
    ("measures", "is_better"),
    [
        ([GOOD, GOOD, BAD, GOOD], True),
        ([GOOD, GOOD, GOOD, BAD], True),
        ([GOOD, GOOD, BAD, BAD], False),  # no better than before
        ([GOOD, WORSE, GOOD, GOOD], False),  # 1.5 lost on what went well
        ([GOOD, replace(GOOD, driving_score=98.5), GOOD, GOOD], True),  # 0.75 lost
    ],
)
def test_a_trial_must_be_better_as_a_whole_and_lose_nothing_of_what_went_well(guard, measures, is_better):
    first = guard.first([GOOD, GOOD, BAD, BAD])
    assert guard.prefers(guard.trial(1, measures, 0.5), first) is is_better


@pytest.mark.parametrize(("share", "between"), [(0.0, 1.0), (0.25, 1.5), (1.0, 3.0)])
def test_a_mixture_lies_between_the_weights(share, between):
    old, new = {"a": np.full((2, 3), 1.0, dtype=np.float32)}, {"a": np.full((2, 3), 3.0, dtype=np.float32)}
    mixed = mixture(old, new, share)
    assert mixed["a"].dtype == np.float32
    np.testing.assert_array_equal(mixed["a"], np.full((2, 3), between, dtype=np.float32))
