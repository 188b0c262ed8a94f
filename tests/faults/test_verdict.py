"""Judging a campaign: what makes a run unsafe, and the rows that come of it."""

import dataclasses

import pytest

from roadmend.faults.campaign import FaultTrial
from roadmend.faults.evidence import Evidence
from roadmend.faults.fault import MethodFault, SignalFault, TopicFault
from roadmend.faults.trial import Disturbed
from roadmend.faults.verdict import HEADING, campaign_rows, judge, table

FAULT = SignalFault(name="killed", node="policy", signal="KILL", declared="STALE_COMMAND", exits=(1,))
BARE = (
    FaultTrial(None, "lockstep", 1.0, 0),
    Disturbed(True, 0, "GOAL", 3.0, False, False, (), True, False, Evidence(100, 0), ()),
)
SEEN = Evidence(100, 2, is_declared=True, silence=1.0, to_state=0.1, to_standstill=1.5)
GOOD = Disturbed(True, 1, "GOAL", 2.0, True, False, (), True, False, SEEN, ())
TRIAL = FaultTrial(FAULT, "lockstep", 1.0, 0)


def judged(**changes):
    return judge([BARE, (TRIAL, dataclasses.replace(GOOD, **changes))])[1]


def test_a_good_run_is_safe_and_reported():
    assert judged().faults == ()
    assert judged().is_reported


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({"exit_code": None}, "hung"),
        ({"exit_code": 0}, "exit code 0"),
        ({"left": ("process sim_node",)}, "left process sim_node"),
        ({"traceback": True}, "a bare traceback"),
        ({"is_tree_whole": False}, "changed what it does not own"),
        ({"evidence": None}, "lost the bag"),
        ({"outcome": "COLLISION"}, "collided"),
    ],
)
def test_each_of_these_is_not_safe(changes, fault):
    assert judged(**changes).faults == (fault,)


def test_a_collision_that_the_undisturbed_run_has_too_is_not_the_faults():
    bare = (BARE[0], dataclasses.replace(BARE[1], outcome="COLLISION"))
    found = judge([bare, (TRIAL, dataclasses.replace(GOOD, outcome="COLLISION"))])
    assert found[1].faults == ()


@pytest.mark.parametrize(
    "changes", [{"named": False}, {"evidence": dataclasses.replace(SEEN, is_declared=False)}, {"evidence": None}]
)
def test_what_nobody_named_or_the_bag_does_not_show_is_not_reported(changes):
    assert not judged(**changes).is_reported


def test_in_real_time_nobody_is_taken_away_without_a_tick_that_shows_it():
    quiet = dataclasses.replace(GOOD, evidence=Evidence(100, 0))
    realtime, lockstep = (judge([(FaultTrial(FAULT, clock, 1.0, 0), quiet)])[0] for clock in ("realtime", "lockstep"))
    assert lockstep.is_reported
    assert not realtime.is_reported


def test_where_no_message_lacked_for_long_enough_there_is_nothing_to_report():
    fault = TopicFault(name="half", topic="policy/command", distortion="silent", share=0.5, declared="STALE_COMMAND")
    trial = FaultTrial(fault, "realtime", 5.0, 0)
    unsaid = dataclasses.replace(GOOD, exit_code=0, named=False, evidence=Evidence(100, 0))
    lacked = dataclasses.replace(unsaid, evidence=Evidence(100, 0, silence=1.0))
    assert judge([(trial, unsaid)])[0].is_reported
    assert not judge([(trial, lacked)])[0].is_reported


def test_who_goes_on_again_is_named_by_the_state_where_it_must_be_declared():
    fault = SignalFault(
        name="stopped", node="policy", signal="STOP", resume=1.0, declared="STALE_COMMAND", exits=(0,), named=False
    )
    assert fault.said == "STALE_COMMAND"
    unsaid = dataclasses.replace(GOOD, exit_code=0, named=False)
    for clock, evidence, is_reported in (
        ("realtime", SEEN, False),
        ("lockstep", SEEN, False),
        ("lockstep", dataclasses.replace(SEEN, silence=None, is_declared=False), True),
    ):
        found = judge([(FaultTrial(fault, clock, 1.0, 0), dataclasses.replace(unsaid, evidence=evidence))])
        assert found[0].is_reported is is_reported
    (said,) = judge([(FaultTrial(fault, "realtime", 1.0, 0), dataclasses.replace(unsaid, named=True))])
    assert said.is_reported


def test_a_fault_that_came_too_late_is_no_run():
    late = judged(injected=False, exit_code=0, named=False, evidence=None, outcome="COLLISION")
    assert (late.faults, late.is_reported, late.is_new_collision) == ((), True, False)
    (row,) = campaign_rows([late])
    assert (row["runs"], row["safe"], row["reported"], row["collisions"]) == (0, 0, 0, 0)
    assert all(len(line) == len(HEADING) for line in table([row]))


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({"exit_code": None}, "hung"),
        ({"left": ("process sim_node",)}, "left process sim_node"),
        ({"traceback": True}, "a bare traceback"),
        ({"is_tree_whole": False}, "changed what it does not own"),
    ],
)
def test_what_no_run_may_do_is_judged_of_one_whose_fault_came_too_late_too(changes, fault):
    late = judged(injected=False, **changes)
    assert late.faults == (fault,)
    assert campaign_rows([late])[0]["faults"] == [fault]


def test_the_row_tells_how_many_and_how_soon():
    late = dataclasses.replace(GOOD, evidence=dataclasses.replace(SEEN, to_state=0.4))
    rows = campaign_rows(judge([BARE, (TRIAL, GOOD), (FaultTrial(FAULT, "lockstep", 1.0, 1), late)]))
    assert [row["fault"] for row in rows] == ["no fault", "killed"]
    row = rows[1]
    assert (row["runs"], row["safe"], row["reported"], row["lost_messages"]) == (2, 2, 2, 4)
    assert (row["must_declare"], row["within_3_ticks"]) == (2, 1)
    assert row["seconds_to_state"] == pytest.approx(0.25)
    assert row["seconds_to_state_max"] == pytest.approx(0.4)
    assert all(len(line) == len(HEADING) for line in table(rows))


def test_what_was_kept_is_what_was_found():
    assert Disturbed.parse(GOOD.as_dict()) == GOOD
    assert Disturbed.parse(dataclasses.replace(GOOD, evidence=None).as_dict()).evidence is None


def test_a_message_that_was_distorted_must_be_declared_on_both_clocks():
    fault = TopicFault(name="nan", topic="policy/command", distortion="nan", declared="INVALID_COMMAND")
    quiet = dataclasses.replace(GOOD, exit_code=0, evidence=Evidence(100, 0, silence=1.0))
    for clock in ("lockstep", "realtime"):
        (found,) = judge([(FaultTrial(fault, clock, 1.0, 0), quiet)])
        assert found.faults == ()
        assert not found.is_reported


def test_a_method_that_cannot_be_used_needs_no_bag_but_one_line():
    fault = MethodFault(name="no model", method="missing", exits=(2,))
    refused = Disturbed(True, 2, "", None, True, False, (), True, False, None, ("roadmend: m: no such model file",))
    trial = FaultTrial(fault, "lockstep", 1.0, 0)
    assert judge([(trial, refused)])[0].faults == ()
    (wordy,) = judge([(trial, dataclasses.replace(refused, stderr=("a", "b")))])
    assert wordy.faults == ("2 lines in place of one",)
