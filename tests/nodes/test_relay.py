"""relay_node: what comes in goes out, distorted while it shall be; and the first that was is told."""

import json

import pytest
import rclpy

from roadmend.core.command import Command
from roadmend.core.errors import InputError
from roadmend.core.tick import INTERVAL_NS
from roadmend.nodes.diagnostics import Level
from roadmend.nodes.relay import RelayNode
from roadmend.recording import messages, topics
from roadmend.recording.codec import encode


class Tape:
    def __init__(self):
        self.got = []

    def publish(self, data):
        self.got.append(messages.COMMAND.decode(data))


@pytest.fixture
def relay(domain, tmp_path, monkeypatch):
    """Makes a relay with parameters."""
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path / "log"))
    made = []

    def make(**parameters):
        told = {"report": str(tmp_path / "touched.json"), **parameters}
        words = [word for name, value in told.items() for word in ("-p", f"{name}:={json.dumps(value)}")]
        rclpy.init(args=["test", "--ros-args", *words], domain_id=domain)
        made.append(RelayNode())
        return made[-1]

    yield make
    for node in made:
        node.destroy_node()
    rclpy.try_shutdown()


def command_at(tick):
    return encode(messages.command_message_of(Command(0.5, 0.0), messages.header_at(tick * INTERVAL_NS)))


def test_it_distorts_while_it_shall_and_tells_the_first(relay, tmp_path):
    link = "policy/command>before/policy/command>policy/command"
    node, tape = relay(links=[link], distortion="both_pedals", begin=3, ticks=2), Tape()
    assert [one.topic_name for one in node.publishers if "policy" in one.topic_name] == ["/policy/command"]
    assert node._health().level is Level.OK
    for tick in range(6):
        node._on_message(topics.POLICY_COMMAND, tape, command_at(tick))
    assert [message.brake > 0.0 for message in tape.got] == [False, False, False, True, True, False]
    assert json.loads((tmp_path / "touched.json").read_text()) == {"first": 3 * INTERVAL_NS}
    assert node._health().level is Level.WARN


@pytest.mark.parametrize(("name", "is_first"), [("stranger", False), ("first_stranger", True)])
def test_a_stranger_asks_for_full_throttle_and_comes_when_it_shall(name, is_first, relay):
    node = relay(links=["policy/command"], distortion=name, begin=2, ticks=1)
    assert (node._publisher is not None) == is_first
    tape = Tape()
    node._publisher, node._open = tape if is_first else None, lambda: tape
    for tick in range(5):
        node._on_tick(command_at(tick))  # of which it reads the stamp
    assert [(message.throttle, messages.stamp_of(message.header)) for message in tape.got] == [(1.0, 2 * INTERVAL_NS)]


@pytest.mark.parametrize("links", [[], ["nowhere>a>b"]])
def test_links_that_name_no_topic_are_refused(links, relay):
    with pytest.raises(InputError, match="names no topic"):
        relay(links=links)
