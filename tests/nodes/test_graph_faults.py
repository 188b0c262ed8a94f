"""Faults in the running graph: who hangs is named, ended and started anew, and nothing that was counted is lost with it."""

import os
import signal
import time
from pathlib import Path

import pytest
import rclpy
from rclpy.context import Context
from rclpy.node import Node
from roadmend_msgs.msg import Command, RepairState

from roadmend.core.tick import INTERVAL_NS
from roadmend.nodes import qos
from roadmend.nodes.writer_gate import FIRST
from roadmend.recording import topics
from roadmend.recording.reader import BagReader

from .graph_run import ENOUGH, Run, records, stamp_of

pytestmark = [pytest.mark.graph, pytest.mark.slow]

POLICY = """
import time

from roadmend.core.command import Command, Decision, Trajectory


class Stay:
    name = "stay"

    def reset(self, route):
        pass

    def step(self, scene):
        time.sleep(0.005)  # so that there is time for a fault in lockstep too
        return Decision(Command(0.0, 0.2), Trajectory.empty())
"""


# Slow until it is told that nobody waits for anything any more.
PACED = POLICY.replace("import time\n", "import time\nfrom pathlib import Path\n").replace(
    "time.sleep(0.005)", 'time.sleep(0.0 if Path(__file__).with_name("hurry").exists() else 0.05)'
)

QUICK = ("--ros-args", "-p", "sim_node:command_timeout:=1.0")  # lockstep: to drive on without who is gone


@pytest.fixture
def run(domain, scenario_file, tmp_path, own):
    started = []
    name = own(POLICY)

    def start(*more, time_limit=8.0):
        started.append(
            Run(scenario_file("S3", 3, actors=[], time_limit=time_limit), tmp_path, "--policy", f"{name}:Stay", *more)
        )
        return started[-1]

    yield start
    for one in started:
        one.close()


@pytest.mark.parametrize("rate", ["0.5", "2", "5"])
def test_a_policy_that_hangs_is_a_controlled_stop_within_three_ticks_and_is_started_anew(run, rate):
    there = run("--clock", "realtime", "--rate", rate, "--silence", "1.5", time_limit=20.0 * float(rate))
    there.until_driving()
    os.kill(there.node("policy_node"), signal.SIGSTOP)
    code, result, said = there.end()
    assert code == 1
    assert "policy_node hung: no sign of life for 1.5 s, restarted" in said
    assert result["faults"][0] == "policy_node hung: no sign of life for 1.5 s, restarted"
    assert result["restarts"] == 1
    asked = [stamp_of(message) for message in records(there.bag, "/policy/command")]
    before = max(range(1, len(asked)), key=lambda number: asked[number] - asked[number - 1])
    last, again = asked[before - 1], asked[before]
    assert again - last > 10 * INTERVAL_NS
    states = [one for one in records(there.bag, "/repair/state") if last < stamp_of(one) < again]
    if states[0].state != states[0].STALE_COMMAND:
        # It was stopped between two of those who listen to it: repair_node had its last command, the recorder had not.
        last, states = stamp_of(states[0]), states[1:]
    assert states[0].state == states[0].STALE_COMMAND
    assert (stamp_of(states[0]) - last) // INTERVAL_NS <= 3 + 1  # the oldest tick without an answer is the one after it
    assert all(state.final_action <= -0.4 for state in states if state.state == state.STALE_COMMAND)
    # The repair node speaks all the while. A busy machine holds it up for some ticks, and the simulator brakes then.
    ticks = (again - last) // INTERVAL_NS
    assert len(states) >= 0.75 * ticks
    assert result["watchdog_ticks"] <= 0.25 * ticks


@pytest.mark.parametrize("clock", ["lockstep", "realtime"])
@pytest.mark.parametrize("name", ["policy_node", "repair_node", "sim_node"])
def test_who_hangs_before_the_first_answer_ends_the_run_with_its_name(run, name, clock):
    there = run("--clock", clock, "--start-deadline", "10")
    os.kill(there.node(name), signal.SIGSTOP)
    code, result, said = there.end()
    assert (code, result) == (1, None)
    assert "the drive did not begin within 10 s, for want of" in said
    assert name in said.splitlines()[-1]
    assert "Traceback" not in said
    assert BagReader(there.bag).topics  # the bag was completed


@pytest.mark.parametrize("clock", ["lockstep", "realtime"])
def test_a_simulator_that_hangs_ends_the_run_and_the_bag_reads(run, clock):
    there = run("--clock", clock, "--silence", "2", time_limit=200.0)
    there.until_driving()
    os.kill(there.node("sim_node"), signal.SIGSTOP)
    code, result, said = there.end()
    assert (code, result) == (1, None)
    assert said.splitlines()[-1] == "roadmend: sim_node failed (-9): hung: no sign of life for 2 s"
    assert records(there.bag, "/ego")


@pytest.mark.parametrize("name", ["policy_node", "repair_node"])
def test_in_lockstep_who_hangs_is_started_anew_too(run, own, name):
    there = run("--policy", f"{own(PACED)}:Stay", "--silence", "2", *QUICK, time_limit=80.0)
    there.until_driving()
    os.kill(there.node(name), signal.SIGSTOP)
    there.until_said(f"{name} hung: no sign of life for 2 s, restarted")
    there.until_seen("/policy/command", Command)
    there.until_seen("/repair/state", RepairState)
    Path("hurry").touch()
    code, result, _ = there.end()
    assert code == 1
    assert result["restarts"] >= 1


def test_a_recorder_that_hangs_is_ended_and_its_bag_is_said_to_be_cut(run):
    there = run("--clock", "realtime", "--rate", "2", "--silence", "4", time_limit=30.0)
    there.until_driving()
    os.kill(there.node("recorder_node"), signal.SIGSTOP)
    code, result, said = there.end()
    assert (code, result["recording_error"]) == (1, "hung: no sign of life for 4 s")
    assert "recorder_node ended (-9), driving on without it: hung: no sign of life for 4 s" in said


@pytest.mark.parametrize("name", ["policy_node", "repair_node"])
def test_who_falls_silent_shortly_before_the_end_is_named_too(run, name):
    there = run("--clock", "realtime", "--rate", "2", "--silence", "10", time_limit=14.0)
    there.until_driving(settled=False)
    os.kill(there.node(name), signal.SIGSTOP)
    code, result, said = there.end()
    assert code == 1
    assert f"{name} hung: no sign of life for 10 s, at the end" in result["faults"]
    assert all(fault.startswith(name) and fault in said for fault in result["faults"])
    assert result["restarts"] == 0


def test_in_lockstep_markers_that_hang_just_before_the_end_are_named_too(run, own):
    there = run("--policy", f"{own(PACED)}:Stay", "--viz", "--silence", "10", time_limit=20.0)
    number = there.node("viz_node")
    there.until_driving(settled=False)
    os.kill(number, signal.SIGSTOP)
    Path("hurry").touch()
    code, result, said = there.end()
    assert (code, result["faults"]) == (1, ["viz_node hung: no sign of life for 10 s, at the end"])
    assert result["faults"][0] in said


def test_in_real_time_a_policy_that_is_slow_to_begin_is_waited_for_and_then_driven(run, own):
    slow = own(POLICY.replace("time.sleep(0.005)  #", "time.sleep(0.0 if scene.time else 3.0)  #"))
    there = run("--policy", f"{slow}:Stay", "--clock", "realtime", "--rate", "2", time_limit=6.0)
    _, _, said = there.end()
    states = records(there.bag, "/repair/state")
    assert states, said
    assert stamp_of(states[0]) == 0
    assert states[0].state == states[0].RESET  # the policy's own command, at the very first tick
    assert not [state for state in states if state.state == state.STARTING]


ALWAYS = """
from roadmend import Proposal


class Always:
    name = "always"

    def reset(self, route):
        pass

    def propose(self, scene, decision):
        return Proposal(1.0, 0.0, action=-0.5)
"""


def test_what_a_killed_repair_node_has_counted_is_in_the_result(run, own):
    there = run("--policy", f"{own(PACED)}:Stay", "--repair", f"{own(ALWAYS)}:Always", *QUICK, time_limit=60.0)
    for _ in range(2):
        there.until_seen("/repair/state", RepairState, lambda state: state.state == state.REPAIRED)
        os.kill(there.node("repair_node"), signal.SIGKILL)
    there.until_seen("/repair/state", RepairState, lambda state: state.state == state.REPAIRED)
    Path("hurry").touch()
    code, result, said = there.end()
    assert (code, result["restarts"]) == (1, 2), said
    replaced = {stamp_of(state) for state in records(there.bag, "/repair/state") if state.intervened}
    assert result["interventions"] >= len(replaced) > 3 * ENOUGH
    assert "repair_node ended (-9), restarted" in said


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_simulator_that_is_told_to_stop_before_the_drive_begins_ends_the_run_in_a_line(run, number):
    there = run()
    os.kill(there.node("sim_node"), number)
    code, result, said = there.end()
    assert (code, result) == (1, None), said
    assert "Traceback" not in said
    assert "sim_node" in said.splitlines()[-1]


def test_what_a_recorder_that_was_stopped_for_a_while_has_lost_is_said(run):
    there = run("--clock", "realtime", "--rate", "5", "--silence", "60", time_limit=60.0)
    there.until_driving(settled=False)
    number = there.node("recorder_node")
    os.kill(number, signal.SIGSTOP)
    time.sleep(3.0)
    os.kill(number, signal.SIGCONT)
    _, result, said = there.end()
    assert result["lost_messages"] > 0
    assert f"bag: {result['lost_messages']} messages were lost on their way to the recorder" in said
    assert BagReader(there.bag).metadata["roadmend"]["lost_messages"] == str(result["lost_messages"])


def test_in_lockstep_a_recorder_that_was_stopped_for_a_while_has_lost_nothing(run):
    there = run(time_limit=60.0)
    there.until_driving(settled=False)
    number = there.node("recorder_node")
    for _ in range(3):
        os.kill(number, signal.SIGSTOP)
        time.sleep(0.6)
        os.kill(number, signal.SIGCONT)
        time.sleep(0.2)
    code, result, said = there.end()
    assert code == 0, said
    assert result["lost_messages"] == 0
    ticks = {record.time_ns for record in BagReader(there.bag).records([topics.CLOCK])}
    assert len(ticks) == round(result["duration"] / 0.05) + 1


@pytest.mark.parametrize("topic", ["/policy/command", "/repair/command"])
def test_a_stranger_on_a_command_topic_is_not_obeyed_and_named_and_the_run_goes_on(run, domain, topic):
    there = run("--repair", "none", "--clock", "realtime", "--rate", "1", time_limit=14.0)
    there.until_seen(
        topic, Command, ticks=FIRST
    )  # a stranger that is there earlier is not told apart: nobody is obeyed
    context = Context()
    rclpy.init(context=context, domain_id=domain)
    node = Node("intruder", context=context)
    publisher = node.create_publisher(Command, topic, qos.COMMAND)
    try:
        while there.process.poll() is None:
            message = Command(throttle=1.0)
            message.header.frame_id = "map"
            publisher.publish(message)
            time.sleep(0.1)
    finally:
        node.destroy_node()
        context.try_shutdown()
    code, result, said = there.end()
    assert code == 0, said
    assert result["outcome"] == "TIMEOUT"  # it stood, as its policy wanted
    assert [line for line in result["warnings"] if topic.strip("/") in line and "/intruder" in line]
    assert "/intruder" in said
    late = [message for message in records(there.bag, "/ego") if stamp_of(message) > 9 * 10**9]
    assert late
    assert all(message.twist.twist.linear.x < 0.01 for message in late)
    said_of = [status for array in records(there.bag, "/diagnostics") for status in array.status]
    assert [status for status in said_of if "/intruder" in status.message and status.level in (1, b"\x01")]
