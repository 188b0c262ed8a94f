"""A policy in a node of its own, over real DDS: it is waited for, what is wrong with it is named, and then it drives."""

import os
import subprocess
import sys
import threading
from pathlib import Path

import pytest
from rclpy.qos import QoSProfile, ReliabilityPolicy
from roadmend_msgs import msg
from std_msgs.msg import String

from roadmend.nodes import qos
from roadmend.nodes.announcement import Announcement, account
from roadmend.nodes.graph_options import GraphOptions
from roadmend.nodes.launcher import run_graph
from roadmend.nodes.policy_watch import NO_TRAJECTORY
from roadmend.recording import topics
from roadmend.recording.reader import BagReader

from .graph_run import Run

pytestmark = [pytest.mark.graph, pytest.mark.slow]

EXAMPLE = Path(__file__).parents[2] / "src" / "examples" / "external_policy.py"
BEST_EFFORT = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)


@pytest.fixture
def run(domain, scenario_file, tmp_path):
    started = []

    def start(*more, time_limit=3.0):
        started.append(Run(scenario_file("S3", 3, time_limit=time_limit), tmp_path, "--policy", "external", *more))
        return started[-1]

    yield start
    for one in started:
        one.close()


@pytest.fixture
def example(domain):
    """Starts the example."""
    started = []

    def start(*more):
        environment = os.environ | {"ROS_DOMAIN_ID": str(domain)}
        started.append(subprocess.Popen([sys.executable, str(EXAMPLE), *more], env=environment))
        return started[-1]

    yield start
    for one in started:
        one.kill()  # how it ends is not what is tested, and rclpy's own handler sometimes misses SIGTERM in this build
        one.wait()


def test_the_example_is_of_at_most_forty_lines():
    assert len(EXAMPLE.read_text(encoding="utf-8").splitlines()) <= 40


def test_it_is_waited_for_with_all_that_it_needs_and_drives_without_a_trajectory(run, example, domain, tmp_path):
    there = run("--repair", "adreft")
    line = there.until_said("waiting for a policy", "nobody publishes it yet")
    for word in (
        "roadmend_msgs/msg/Command on /policy/command",
        "reliable",
        "deadline 0.5 s",
        f"ROS_DOMAIN_ID={domain}",
    ):
        assert word in line
    example()
    there.until_said(NO_TRAJECTORY)
    there.until_said("adreft behind external: model modular", "since none was made for it")
    code, told, said = there.end()
    assert code == 0, said
    assert told["ticks"] > 50
    assert told["watchdog_ticks"] == 0
    reader = BagReader(tmp_path / "bag")
    record = reader.metadata["roadmend"]
    assert told["policy"] == record["policy"] == "external:/even_pace"
    assert record["policy_node"] == "/even_pace"
    states = [message.value for message in reader.messages(["/repair/state"])]
    assert all(NO_TRAJECTORY in state.reason for state in states)
    assert {state.state for state in states} <= {state.PASS for state in states} | {state.RESET for state in states} | {
        1
    }


def test_whatever_is_wrong_with_its_publisher_is_named_until_it_is_right(run, node, example):
    there = run(time_limit=20.0)
    there.until_said("nobody publishes it yet")
    one, two, three = node("one"), node("two"), node("three")
    for wrong, kind, profile, words in (
        (one, msg.Command, BEST_EFFORT, ("/one offers an incompatible QoS", "reliab")),
        (two, msg.Command, 1, ("/two offers an incompatible QoS", "eadline")),
        (three, String, qos.COMMAND, ("/three publishes std_msgs/msg/String", "publish roadmend_msgs/msg/Command")),
    ):
        publisher = wrong.create_publisher(kind, topics.POLICY_COMMAND, profile)
        there.until_said("waiting for a policy", *words)
        wrong.destroy_publisher(publisher)
    good = [each.create_publisher(msg.Command, topics.POLICY_COMMAND, qos.COMMAND) for each in (one, two)]
    there.until_said("waiting for a policy", "2 publishers, /one and /two; end all but one")
    two.destroy_publisher(good.pop())
    there.until_said("waiting for an answer to the first tick", "for want of command")
    stray = msg.Command()
    stray.header.stamp.sec = 1_700_000_000
    sending = threading.Event()
    threading.Thread(target=lambda: [good[0].publish(stray) for _ in iter(lambda: sending.wait(0.05), True)]).start()
    there.until_said("waiting for an answer to the first tick", "belong to no tick", "copy header.stamp")
    sending.set()
    one.destroy_publisher(good.pop())
    example()
    _, told, said = there.end()
    assert told["policy"] == "external:/even_pace", said  # nobody else has driven


def test_a_second_publisher_beside_our_own_policy_is_named(node, scenario_file, tmp_path):
    node("intruder").create_publisher(msg.Command, topics.POLICY_COMMAND, qos.COMMAND)
    scenario = scenario_file("S3", 3, time_limit=10.0)  # five seconds by the wall: a discovery that misses takes three
    result = run_graph(GraphOptions(scenario, clock="realtime", rate=2.0, bags=tmp_path, name="bag", viz=False))
    assert result.warnings == ("policy/command: has 2 publishers, /intruder and /policy_node; end all but one",)
    assert result.episode.policy == "external:/intruder + modular"


def test_what_it_announces_is_what_the_bag_carries():
    values = {"role": "policy", "class": "theirs.Driver", "package": "theirs 2.1", "model_sha256": "ab"}
    known = account({"/mine": Announcement("/mine", "careful", values)}, ["/mine"], [])
    assert known["policy"] == "external:careful"
    assert (known["policy_node"], known["policy_class"], known["policy_package"]) == (
        "/mine",
        "theirs.Driver",
        "theirs 2.1",
    )
    assert known["method"] == "unknown"
