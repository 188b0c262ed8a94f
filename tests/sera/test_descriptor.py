"""What is known of a scenario's outcomes."""

import pytest

from roadmend.sera.descriptor import OutcomeStatistics, outcome_name

from .banks import PLAIN, ran


def test_outcomes_of_one_policy_and_method_add_up_others_stand_beside():
    known = PLAIN.with_outcomes(ran("GOAL", 3.0)).with_outcomes(ran("COLLISION", 0.0))
    assert known.outcomes == (OutcomeStatistics("modular", {"COLLISION": 1, "GOAL": 1}, 0.0),)
    more = known.with_outcomes((OutcomeStatistics("modular", {"GOAL": 2}, 4.0, "adreft"),))
    assert [each.method for each in more.outcomes] == ["adreft", "none"]
    assert (known.difficulty, more.difficulty, PLAIN.difficulty) == (0.5, 0.25, None)


def test_an_unknown_outcome_is_refused():
    with pytest.raises(ValueError, match="no outcome 'CRASH'"):
        outcome_name("CRASH")
