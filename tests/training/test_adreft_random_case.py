"""Scenarios drawn at random to practise on."""

from roadmend.training.adreft.random_case import random_cases
from roadmend.world.families import FAMILIES


def test_every_policy_gets_scenarios_of_its_own_of_every_family_and_always_the_same():
    found = random_cases("modular", 3)
    assert found == random_cases("modular", 3) == random_cases("modular", 5)[:15]
    assert {family: sum(case.family == family for case in found) for family in FAMILIES} == dict.fromkeys(FAMILIES, 3)
    assert not {case.name for case in found} & {case.name for case in random_cases("neural", 3)}
    assert random_cases("modular", 0) == []


def test_a_case_is_a_scenario_that_nobody_has_driven():
    case = random_cases("modular", 1)[0]
    assert (case.digest, case.is_violation) == ("", False)
    assert case.scenario().name == case.name
    assert case.scenario().family == case.family


def test_nobody_practises_on_what_a_model_is_judged_by():
    judged = {case.name for policy in ("modular", "neural") for case in random_cases(policy, 20, validation=True)}
    assert len(judged) == 2 * 20 * len(FAMILIES)
    assert not judged & {case.name for policy in ("modular", "neural") for case in random_cases(policy, 20)}
