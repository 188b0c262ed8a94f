"""What is lost by learning: ordinary scenarios alone, and those that went well once more."""

from dataclasses import replace

import pytest

from harness.forgetting import REDRAWS, forgotten, forgotten_anew, redrawn
from harness.sera_plan import Evaluated
from roadmend.measures.driving import DrivingMeasures
from roadmend.world.families import sample_scenario

GOOD = DrivingMeasures("GOAL", 100.0, (), 100.0, True, 80.0, 90.0, False)
BAD = replace(GOOD, outcome="COLLISION", driving_score=30.0, success=False)


@pytest.fixture(scope="module")
def ordinary():
    return Evaluated(sample_scenario("S1", 1), is_hard=False)


@pytest.fixture(scope="module")
def hard():
    return Evaluated(sample_scenario("S1", 2), is_hard=True)


def test_ordinary_scenarios_alone_are_looked_at(ordinary, hard):
    found = forgotten([ordinary, ordinary, hard], [GOOD, BAD, GOOD], [BAD, GOOD, BAD])
    assert found == {
        "ordinary": 2,
        "went_well": 1,
        "ordinary_change": 0.0,
        "driving_score_change": -70.0,
        "success_rate_change": -100.0,
    }
    assert forgotten([hard], [GOOD], [BAD])["driving_score_change"] is None


def test_what_went_well_is_drawn_anew_with_seeds_of_its_own_and_nothing_else_changed(ordinary, hard):
    late = Evaluated(ordinary.scenario.model_copy(update={"seed": 2**31 - 1}), is_hard=False)
    found = redrawn([ordinary, hard, ordinary, late], [GOOD, GOOD, BAD, GOOD])
    assert len(found) == 2 * REDRAWS
    assert len({scenario.seed for scenario in (ordinary.scenario, late.scenario, *found)}) == 2 + 2 * REDRAWS
    assert all(0 <= scenario.seed < 2**31 for scenario in found)
    assert {replaced.model_copy(update={"seed": ordinary.scenario.seed}).digest for replaced in found} == {
        ordinary.scenario.digest
    }
    assert redrawn([ordinary, hard], [BAD, GOOD]) == []


def test_what_was_drawn_anew_tells_the_old_policy_and_the_difference_to_the_new_one():
    assert forgotten_anew([GOOD, BAD], [BAD, BAD]) == {"redrawn_before": 65.0, "redrawn_change": -35.0}
    assert forgotten_anew([BAD], [BAD])["redrawn_change"] == 0.0
    assert forgotten_anew([], []) == {"redrawn_before": None, "redrawn_change": None}
