"""Trials: they are drawn where they may matter, leave the policy alone elsewhere, and are not driven twice."""

import numpy as np
import pytest

from roadmend.core.errors import InputError
from roadmend.core.outcome import EventKind
from roadmend.repair.actions import ACTIONS
from roadmend.training.adreft.configuration import ModelSection
from roadmend.training.adreft.gathering import Recipe
from roadmend.training.adreft.network import AdreftNetwork, save_model
from roadmend.training.adreft.trial_plan import TrialPlan
from roadmend.training.adreft.trials import PASS, CaseTrials, gather_trials, trial_keys, try_case
from roadmend.training.torch_state import tensors_of

from .cases import Drawn

RECIPE = Recipe("modular", "rich", 1)


def test_interventions_begin_in_the_seconds_before_the_collision_and_come_from_the_seed():
    plan = TrialPlan(8, 2, 0, 4, 7)
    drawn = [plan.holds("S1-1", number, 20.0, collides=True) for number in range(1, 200)]
    begins = [holds[0].begin for holds in drawn]
    assert 14.0 <= min(begins) < 14.5
    assert 19.0 < max(begins) <= 19.7
    assert {hold.action for holds in drawn for hold in holds} == set(range(1, len(ACTIONS)))
    assert all(0.2 <= hold.end - hold.begin <= 4.0 + 1e-9 for holds in drawn for hold in holds)
    assert drawn[5] == plan.holds("S1-1", 6, 20.0, collides=True)
    assert drawn[5] != TrialPlan(8, 2, 0, 4, 8).holds("S1-1", 6, 20.0, collides=True)


def test_gentle_trials_begin_earlier_hold_longer_and_brake_little():
    plan = TrialPlan(0, 0, 0, 4, 7, gentle_per_violation=199, gentle_per_success=1)
    drawn = list(plan.gentle_trials("S1-1", EventKind.COLLISION, 20.0))
    assert len(drawn) == 199
    begins = [holds[0].begin for holds in drawn]
    assert 6.0 <= min(begins) < 7.0
    assert 17.0 < max(begins) <= 18.0
    assert {ACTIONS[hold.action] for holds in drawn for hold in holds} == {0.4, 0.2, 0.0, -0.2, -0.4, -0.6}
    assert all(2.0 <= hold.end - hold.begin <= 10.0 + 1e-9 for holds in drawn for hold in holds)
    assert len(list(plan.gentle_trials("S1-1", EventKind.GOAL, 20.0))) == 1
    assert not list(plan.trials("S1-1", EventKind.COLLISION, 20.0))
    cases = [Drawn("S5", 3)]
    assert trial_keys(cases, RECIPE, plan) != trial_keys(cases, RECIPE, TrialPlan(0, 0, 0, 4, 7))


def test_gentle_trials_are_driven_after_the_others(gathered):
    _, abrupt = gathered
    trials = try_case(Drawn("S5", 3), RECIPE, TrialPlan(2, 2, 0, 4, 1, gentle_per_success=1))
    assert len(trials.outcomes) == 4
    assert trials.outcomes[:3].tolist() == abrupt.outcomes.tolist()
    same = len(abrupt.time)
    np.testing.assert_array_equal(trials.choice[:same], abrupt.choice)
    assert set(trials.choice[same:].tolist()) <= {PASS, *range(2, 8)}
    assert (trials.choice[same:] != PASS).sum() >= 10  # 2 s of decisions


@pytest.fixture(scope="module")
def gathered(tmp_path_factory):
    folder = tmp_path_factory.mktemp("trials")
    [trials] = gather_trials([Drawn("S5", 3)], RECIPE, TrialPlan(2, 2, 0, 4, 1), folder, map)
    return folder, trials


def test_a_trial_is_the_policy_alone_but_for_what_is_held(gathered):
    _, trials = gathered
    assert len(trials.outcomes) == 3  # alone, and two trials
    alone = int(trials.lengths[0])
    assert (trials.choice[:alone] == PASS).all()
    assert not trials.dose[:alone].any()  # a policy that asks for more than 0.8 is left alone too
    assert trials.time[0] == 0.0
    np.testing.assert_allclose(np.diff(trials.time[:alone]), 0.2, atol=1e-6)
    assert (trials.choice[alone:] != PASS).any()
    held = trials.choice >= 0
    worth = np.array(ACTIONS)[trials.choice]
    assert (trials.dose[held & (worth < trials.action)] > 0.0).all()
    assert trials.counts.sum() == len(trials.tokens)
    assert trials.lengths.sum() == len(trials.time)


def test_what_is_there_is_not_driven_again_and_what_is_damaged_is(gathered, monkeypatch):
    folder, trials = gathered
    [path] = folder.glob("*.npz")
    again = CaseTrials.load(path)
    np.testing.assert_array_equal(again.tokens, trials.tokens)
    before = path.stat().st_mtime_ns
    gather_trials([Drawn("S5", 3)], RECIPE, TrialPlan(2, 2, 0, 4, 1), folder, map)
    assert path.stat().st_mtime_ns == before
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    gather_trials([Drawn("S5", 3)], RECIPE, TrialPlan(2, 2, 0, 4, 1), folder, map)
    np.testing.assert_array_equal(CaseTrials.load(path).tokens, trials.tokens)


def test_a_case_that_is_driven_otherwise_is_refused():
    with pytest.raises(InputError, match="does not drive it as the corpus says"):
        try_case(Drawn("S5", 3, digest="0" * 64), RECIPE, TrialPlan(0, 0, 0, 4, 1))


def test_a_blinded_policy_collides_where_it_would_not_and_sees_again_later():
    case, plan = Drawn("S5", 3), TrialPlan(1, 0, 4, 4, 1)
    trials = try_case(case, RECIPE, plan)
    assert trials.outcomes[0] == int(EventKind.GOAL)
    collided = int((trials.outcomes[1:] == int(EventKind.COLLISION)).sum())
    assert collided >= 1
    assert len(trials.outcomes) >= 1 + 4 + 1
    again = try_case(case, RECIPE, plan)
    np.testing.assert_array_equal(again.tokens, trials.tokens)


@pytest.fixture(scope="module")
def guide(tmp_path_factory):
    """A model that steps in always and brakes as hard as it can."""
    model = ModelSection(
        tokenizer="rich", hidden=8, layers=1, heads=1, feed_forward=8, monitor=[4], adapter=[4], interval=4
    )
    configuration = model.configuration()
    tensors = tensors_of(AdreftNetwork(configuration))
    last = max(name for name in tensors if name.startswith("adapter.") and name.endswith("weight"))
    tensors[last] = np.zeros_like(tensors[last])
    bias = last.removesuffix("weight") + "bias"
    tensors[bias] = np.zeros_like(tensors[bias])
    tensors[bias][-1] = 1.0
    path = tmp_path_factory.mktemp("guide") / "guide.safetensors"
    return path, save_model(path, configuration, tensors, 0.0)


def test_a_guide_drives_along_and_is_overruled_where_something_is_held(guide):
    path, digest = guide
    plan = TrialPlan(2, 1, 0, 4, 1, digest)
    trials = try_case(Drawn("S5", 3, digest="0" * 64), RECIPE, plan, path)  # the corpus speaks of the policy alone
    alone = int(trials.lengths[0])
    assert (trials.choice[:alone] == len(ACTIONS) - 1).all()
    assert trials.outcomes[0] == int(EventKind.TIMEOUT)
    assert len(trials.outcomes) == 3  # not at its goal: as many trials as a violation has
    assert len(set(trials.choice[alone:].tolist())) > 1
    cases = [Drawn("S5", 3)]
    assert trial_keys(cases, RECIPE, plan) != trial_keys(cases, RECIPE, TrialPlan(2, 1, 0, 4, 1))


def test_with_a_guide_to_leave_the_policy_alone_is_drawn_too():
    drawn = {
        hold.action
        for number in range(1, 200)
        for hold in TrialPlan(8, 2, 0, 4, 7, "guide").holds("S1-1", number, 20.0, collides=False)
    }
    assert drawn == set(range(len(ACTIONS)))
