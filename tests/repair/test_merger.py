import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from roadmend.core.command import Command
from roadmend.core.repair import Proposal, RepairTrigger
from roadmend.repair.merger import merge, proposal_fault

GRID = [step / 10 for step in range(-10, 11)]
BAD = [math.nan, math.inf, -math.inf]
actions = st.floats(-1.0, 1.0)
finite = st.floats(-1e6, 1e6)


@pytest.mark.parametrize("score", [0.0, 0.5, 0.5 + 1e-12, 1.0])
@pytest.mark.parametrize("change_lane", [False, True])
def test_every_pair_of_actions_follows_the_definition(score, change_lane):
    for policy in GRID:
        command = Command.from_action(policy, change_lane=change_lane)
        for action in GRID:
            merged = merge(command, Proposal(score, 0.5, action))
            if score > 0.5 and policy > action:
                assert merged.action == pytest.approx(action)
                assert merged.fault == ""
                assert merged.change_lane == change_lane
            else:
                assert merged is command


@given(actions, actions, finite, finite, st.booleans())
def test_never_raises_the_acceleration(policy, action, score, threshold, change_lane):
    command = Command.from_action(policy, change_lane=change_lane)
    merged = merge(command, Proposal(score, threshold, action))
    assert merged.action <= command.action
    assert merged.change_lane is change_lane
    assert merged.fault == ""
    assert (merged is command) == (not (score > threshold and policy > action))


@given(actions, actions, st.sampled_from([0.0, 1.0]), st.booleans(), st.booleans())
def test_a_lane_change_is_begun_only_where_it_was_asked_for_and_not_held_back(policy, action, score, asked, held_back):
    command = Command.from_action(policy, change_lane=asked)
    merged = merge(command, Proposal(score, 0.5, action, hold_back=held_back))
    assert merged.change_lane is (asked and not held_back)
    assert merged.action == merge(command, Proposal(score, 0.5, action)).action  # holding back moves no pedal
    if not asked and score < 0.5:
        assert merged is command


def test_score_equal_to_the_threshold_does_not_step_in():
    command = Command(0.5, 0.0)
    assert merge(command, Proposal(0.7, 0.7, -1.0)) is command


def test_equal_action_leaves_the_command_object():
    command = Command(0.0, 0.4)
    assert merge(command, Proposal(1.0, 0.5, -0.4)) is command


@pytest.mark.parametrize("bad", BAD)
def test_each_field_that_is_not_finite_is_a_fault(bad):
    assert proposal_fault(Proposal(bad, 0.5, -1.0))
    assert proposal_fault(Proposal(0.5, bad, -1.0))
    assert proposal_fault(Proposal(0.5, 0.5, bad))
    assert proposal_fault(Proposal(bad, bad, -1.0))
    assert proposal_fault(Proposal(bad, bad, bad))


@pytest.mark.parametrize("action", [-1.0 - 1e-9, 1.0 + 1e-9, -2.0, 5.0])
def test_action_out_of_range_is_a_fault(action):
    assert "outside" in proposal_fault(Proposal(1.0, 0.5, action))


@pytest.mark.parametrize("action", GRID)
def test_sound_proposals_have_no_fault(action):
    assert proposal_fault(Proposal(0.3, 0.5, action)) == ""


def test_only_the_full_throttle_goes_without_score_and_threshold():
    assert proposal_fault(Proposal(math.nan, math.nan, 1.0)) == ""
    assert proposal_fault(Proposal(math.nan, math.nan, 0.8))
    assert proposal_fault(Proposal(math.inf, math.inf, 1.0))


@given(st.floats(), st.floats(), st.floats())
def test_whatever_has_no_fault_is_finite_or_has_no_opinion(score, threshold, action):
    if not proposal_fault(Proposal(score, threshold, action)):
        assert math.isfinite(action)
        assert math.isfinite(score) == math.isfinite(threshold)
        assert math.isfinite(score) or action == 1.0


TOLD = {
    "triggers": [
        None,
        3,
        "7",
        {7: 0.3},
        (3,),
        (None,),
        (RepairTrigger(7, 0.3), RepairTrigger(-1, 0.3)),
        (RepairTrigger(2**32, 0.3),),
        (RepairTrigger(7.0, 0.3),),
        (RepairTrigger("7", 0.3),),
        (RepairTrigger(7, None),),
        (RepairTrigger(7, "0.3"),),
        (RepairTrigger(7, 10**400),),
        *((RepairTrigger(7, bad),) for bad in BAD),
    ],
    "worth": ["much", [0.3], *BAD],
    "reason": [None, 3, b"because", "\ud800"],
    "hold_back": [None, 1, math.nan, np.ones(2)],
}


@pytest.mark.parametrize(("field", "value"), [(field, value) for field, values in TOLD.items() for value in values])
@pytest.mark.parametrize("opinion", [(0.3, 0.5, -0.5), (math.nan, math.nan, 1.0)])
def test_what_no_message_can_hold_is_a_fault_that_names_the_field(opinion, field, value):
    assert field in proposal_fault(Proposal(*opinion, **{field: value}))


@pytest.mark.parametrize(
    "told",
    [
        {"triggers": (RepairTrigger(0, 0.0), RepairTrigger(2**32 - 1, -1e300))},
        {"triggers": [RepairTrigger(np.uint32(7), np.float32(0.3))]},
        {"worth": -0.2},
        {"worth": np.float32(0.3)},
        {"reason": "Straße 7 ahead"},
        {"hold_back": np.bool_(True)},
    ],
)
def test_what_a_message_can_hold_is_none(told):
    assert proposal_fault(Proposal(0.3, 0.5, -0.5, **told)) == ""
