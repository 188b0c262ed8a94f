"""How a fault gets into a run: the command line, the detour over the relay, and the files that it is given."""

import json
import subprocess
import sys

import pytest

from roadmend.core.errors import InputError
from roadmend.core.tick import INTERVAL, INTERVAL_NS
from roadmend.faults.campaign import FaultCampaign, FaultTrial
from roadmend.faults.fault import MethodFault, SignalFault, TopicFault
from roadmend.faults.staging import TOUCHED, begin_of, distortion_of, run_command, touched_stamps
from roadmend.repair.adreft.model import AdreftModel


def campaign_of(**rows):
    return FaultCampaign(**rows, repair="rss", earliest=1.0, latest=2.0)


def command_for(fault, folder, kind="topics"):
    trial = FaultTrial(fault, "realtime", 2.0, 0)
    return run_command(campaign_of(**{kind: (fault,)}), trial, folder / "s.yaml", folder)


def ros_of(command):
    words = command[command.index("--ros-args") + 1 :] if "--ros-args" in command else []
    return set(zip(words[::2], words[1::2], strict=True))


def half_missing(**changes):
    known = {"distortion": "silent", "share": 0.5, "declared": "STALE_COMMAND"}
    return TopicFault(name="half", topic="policy/command", **(known | changes))


def test_without_a_fault_the_graph_is_as_it_is(tmp_path):
    trial = FaultTrial(None, "lockstep", 1.0, 0)
    fault = SignalFault(name="k", node="policy", signal="KILL")
    command = run_command(campaign_of(signals=(fault,)), trial, tmp_path / "s.yaml", tmp_path)
    assert ros_of(command) == set()
    assert "--no-viz" in command


@pytest.mark.parametrize(
    ("topic", "remaps", "writer"),
    [
        ("policy/command", {"policy_node:policy/command:=before/policy/command"}, "repair_node:writer:=relay_node"),
        ("policy/trajectory", {"policy_node:policy/trajectory:=before/policy/trajectory"}, ""),
        ("objects", {"repair_node:objects:=behind/objects"}, ""),
        ("repair/command", {"repair_node:repair/command:=before/repair/command"}, "sim_node:writer:=relay_node"),
    ],
)
def test_a_topic_goes_over_the_relay_which_is_obeyed_then(topic, remaps, writer, tmp_path):
    fault = TopicFault(name="silent", topic=topic, distortion="silent", named=False)
    given = ros_of(command_for(fault, tmp_path))
    assert {word for option, word in given if option == "-r"} == remaps
    settings = {word for option, word in given if option == "-p"}
    waited = json.loads(next(word for word in settings if "wait_for" in word).partition(":=")[2])
    assert "relay_node" in waited
    assert ("repair_node" in waited) == (topic != "objects")
    assert {word for word in settings if "writer" in word} == ({writer} if writer else set())


def test_a_clock_jumps_for_policy_and_repair_and_their_answers_come_back(tmp_path):
    fault = TopicFault(name="jump", topic="clock", distortion="jump", shift=-1.0, named=False)
    given = {word for option, word in ros_of(command_for(fault, tmp_path)) if option == "-r"}
    assert given == {
        "policy_node:ego:=behind/ego",
        "policy_node:objects:=behind/objects",
        "repair_node:ego:=behind/ego",
        "repair_node:objects:=behind/objects",
        "repair_node:repair/command:=before/repair/command",
    }


def test_a_fault_begins_where_the_campaign_says_or_after_its_own_time():
    early = TopicFault(name="a", topic="ego", distortion="silent", named=False)
    late = TopicFault(name="b", topic="ego", distortion="silent", named=False, after=5.0)
    campaign = campaign_of(topics=(early, late))
    for seed in range(20):
        assert 1.0 <= begin_of(campaign, FaultTrial(early, "lockstep", 1.0, seed)) <= 2.0
        assert 5.0 <= begin_of(campaign, FaultTrial(late, "lockstep", 1.0, seed)) <= 6.0


@pytest.mark.parametrize("kind", ["missing", "changed", "cut", "foreign"])
def test_a_model_that_cannot_be_used_is_refused(kind, tmp_path):
    command = command_for(MethodFault(name="m", method=kind, exits=(2,)), tmp_path, "methods")
    (model,) = (word.partition(":=")[2] for option, word in ros_of(command) if option == "-p")
    with pytest.raises(InputError):
        AdreftModel.load(tmp_path / json.loads(model))


@pytest.mark.parametrize("kind", ["raises", "not_finite"])
def test_a_method_that_fails_does_so_from_its_moment_on_and_leaves_a_mark(kind, tmp_path):
    fault = MethodFault(name="m", method=kind, ticks=3)
    command_for(fault, tmp_path, "methods")
    begin = round(begin_of(campaign_of(methods=(fault,)), FaultTrial(fault, "realtime", 2.0, 0)) / INTERVAL)
    script = f"""
import math
from types import SimpleNamespace
from broken_method import Broken
def fails(tick):
    try:
        return math.isnan(Broken().propose(SimpleNamespace(time=tick * {INTERVAL}), None).score)
    except RuntimeError:
        return True
print([fails({begin} + step) for step in range(-1, 4)])
"""
    said = subprocess.run(
        [sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True, check=True
    ).stdout
    assert said.strip() == "[False, True, True, True, False]"
    assert (tmp_path / TOUCHED).exists()


@pytest.mark.parametrize(("rate", "in_a_row"), [(0.5, 1), (1.0, 1), (2.0, 2), (5.0, 3), (10.0, 3)])
def test_in_real_time_messages_lack_where_so_many_in_a_row_do_that_the_next_one_comes_too_late(
    tmp_path, rate, in_a_row
):
    fault = half_missing(ticks=200)
    trial = FaultTrial(fault, "realtime", rate, 4)
    campaign = campaign_of(topics=(fault,))
    first = distortion_of(campaign, trial).first_in_a_row("policy/command", in_a_row)
    assert touched_stamps(campaign, trial, tmp_path) == [first * INTERVAL_NS]
    brief = half_missing(ticks=1)
    assert touched_stamps(campaign_of(topics=(brief,)), FaultTrial(brief, "realtime", 5.0, 4), tmp_path) == []


@pytest.mark.parametrize(("clock", "declared"), [("lockstep", "STALE_COMMAND"), ("realtime", "INVALID_COMMAND")])
def test_else_each_message_that_is_touched_counts(tmp_path, clock, declared):
    fault = half_missing(declared=declared)
    trial = FaultTrial(fault, clock, 5.0, 4)
    campaign = campaign_of(topics=(fault,))
    what = distortion_of(campaign, trial)
    touched = [tick * INTERVAL_NS for tick in range(200) if what.touches("policy/command", tick)]
    assert touched_stamps(campaign, trial, tmp_path) == touched
    assert 5 <= len(touched) <= 15


def test_of_a_relay_that_touches_all_the_first_is_what_it_left(tmp_path):
    fault = half_missing(share=1.0, ticks=3)
    asked = campaign_of(topics=(fault,)), FaultTrial(fault, "realtime", 5.0, 4), tmp_path
    assert touched_stamps(*asked) == []
    (tmp_path / TOUCHED).write_text(json.dumps({"first": 7}))
    assert touched_stamps(*asked) == [7, 7 + INTERVAL_NS, 7 + 2 * INTERVAL_NS]


def test_a_method_fails_at_the_ticks_that_are_told_and_a_signal_touches_no_tick(tmp_path):
    fault = MethodFault(name="m", method="raises", ticks=40, share=0.2)
    asked = campaign_of(methods=(fault,)), FaultTrial(fault, "realtime", 2.0, 0), tmp_path
    command_for(fault, tmp_path, "methods")
    script = f"""
from types import SimpleNamespace
from broken_method import Broken
for tick in range(200):
    try:
        Broken().propose(SimpleNamespace(time=tick * {INTERVAL}), None)
    except RuntimeError:
        print(tick * {INTERVAL_NS})
"""
    said = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert touched_stamps(*asked) == [int(line) for line in said.stdout.split()] != []
    signal = SignalFault(name="s", node="policy", signal="KILL")
    assert touched_stamps(campaign_of(signals=(signal,)), FaultTrial(signal, "realtime", 2.0, 0), tmp_path) is None
