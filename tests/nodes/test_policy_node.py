"""policy_node in this process: decisions for complete ticks, and a policy that fails is seen, not fatal."""

import math

import numpy as np
import pytest
import rclpy

from roadmend.core.command import Command, Decision, Trajectory
from roadmend.core.errors import InputError
from roadmend.core.route import Route, Stage
from roadmend.core.scene import EgoState
from roadmend.nodes.diagnostics import Level
from roadmend.nodes.policy import PolicyNode
from roadmend.recording import messages
from roadmend.recording.codec import encode


class Scripted:
    """A policy that counts, and fails when told to."""

    name = "scripted"

    def __init__(self):
        self.steps = self.resets = 0
        self.fails = self.fails_to_reset = False

    def reset(self, route):
        self.resets += 1
        if self.fails_to_reset:
            raise KeyError("no map")

    def step(self, scene):
        if self.fails:
            raise ZeroDivisionError("lost")
        self.steps += 1
        return Decision(Command(self.steps / 1000.0, 0.0), Trajectory.empty())


class Tape:
    def __init__(self, kind):
        self._kind, self.got = kind, []

    def publish(self, data):
        self.got.append((messages.stamp_of_bytes(data) // 50_000_000, self._kind.decode(data)))


class Bench:
    def __init__(self):
        self.node = PolicyNode()
        self.policy = self.node._policy = Scripted()
        self.commands, self.plans = Tape(messages.COMMAND), Tape(messages.TRAJECTORY)
        self.node._command_publisher, self.node._trajectory_publisher = self.commands, self.plans

    def route(self, **changes):
        x = np.linspace(0.0, 500.0, 11)
        stage = Stage(x, 0.0 * x, np.full(11, 15.0))
        message = messages.route_message_of(
            Route("test", 4.7, 1.85, 480.0, 60.0, (stage,), (), ()), messages.header_of(0.0)
        )
        for name, value in changes.items():
            setattr(message, name, value)
        self.node._on_route(encode(message))

    def tick(self, number, *parts, objects=None):
        """Send a tick; returns the numbers of the ticks answered meanwhile."""
        before, header = len(self.commands.got), messages.header_of(0.05 * number)
        for part in parts or ("ego", "objects"):
            if part == "ego":
                ego = EgoState.from_yaw(50.0, 0.0, 0.0, 8.0, 0.0, 4.7, 1.85)
                message = messages.ego_message_of(ego, header)
            else:
                message = objects or messages.OBJECTS()
                message.header = header
            self.node._on_part(part, encode(message))
        assert [stamp for stamp, _ in self.commands.got] == [stamp for stamp, _ in self.plans.got]
        return [stamp for stamp, _ in self.commands.got[before:]]

    @property
    def health(self):
        return self.node._health()


@pytest.fixture
def bench(domain, tmp_path, monkeypatch):
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path))
    rclpy.init(args=["test"], domain_id=domain)
    there = Bench()
    yield there
    there.node.destroy_node()
    rclpy.try_shutdown()


def test_it_decides_when_route_ego_and_objects_are_there(bench):
    assert bench.health.level is Level.WARN
    assert bench.tick(0) == []  # no route yet
    bench.route()
    assert bench.tick(0, "objects") == []
    assert bench.tick(0, "ego") == [0]
    assert bench.tick(1, "ego", "objects") == [1]
    assert (bench.health.level, bench.health.message) == (Level.OK, "driving")


def test_a_repeated_tick_gets_the_same_answer_and_is_decided_once(bench):
    bench.route()
    assert bench.tick(0) + bench.tick(0) + bench.tick(0) == [0, 0, 0]
    assert {message.throttle for _, message in bench.commands.got} == {0.001}
    assert bench.policy.steps == 1


def test_a_new_route_and_stamps_that_run_backwards_reset_the_policy(bench):
    bench.route()
    assert bench.policy.resets == 1
    bench.tick(5)
    bench.tick(6)
    assert bench.policy.resets == 1
    assert bench.tick(2) == [2]
    assert bench.policy.resets == 2
    bench.route()
    assert bench.policy.resets == 3
    assert bench.tick(2) == [2]  # decided anew
    assert bench.policy.steps == 4


def test_a_policy_that_fails_is_reported_and_does_not_end_the_node(bench, capfd):
    bench.route()
    bench.tick(0)
    bench.policy.fails = True
    assert bench.tick(1) + bench.tick(2) == []  # silence, never an old answer
    assert bench.health.level is Level.ERROR
    assert "ZeroDivisionError: lost" in bench.health.message
    assert "ZeroDivisionError: lost" in capfd.readouterr().err
    bench.policy.fails = False
    assert bench.tick(3) == [3]
    assert bench.health.level is Level.OK


def test_a_policy_that_cannot_be_reset_is_reported_and_does_not_end_the_node(bench):
    bench.policy.fails_to_reset = True
    bench.route()
    assert bench.health.level is Level.ERROR
    assert "no map" in bench.health.message
    assert bench.tick(0) == []
    bench.policy.fails_to_reset = False
    bench.route()
    assert bench.tick(0) == [0]
    bench.policy.fails_to_reset = True
    bench.tick(5)
    assert bench.tick(1) == []  # back in time
    assert bench.health.level is Level.ERROR


def test_a_route_that_is_none_is_reported_and_does_not_end_the_node(bench):
    bench.route(y=np.array([1.0]))
    assert bench.health.level is Level.ERROR
    assert "differ in length" in bench.health.message
    assert bench.tick(0) == []
    bench.route()
    assert bench.tick(0) == [0]
    assert bench.health.level is Level.OK


def test_objects_whose_arrays_do_not_fit_are_reported(bench):
    bench.route()
    assert bench.tick(0, objects=messages.OBJECTS(id=np.array([1, 2], dtype=np.uint32))) == []
    assert "differ in length" in bench.health.message
    assert bench.tick(1) == [1]


@pytest.mark.parametrize("part", ["ego", "objects"])
@pytest.mark.parametrize("size", [0, 4, 11, 24])
def test_bytes_that_are_no_message_are_as_good_as_none(bench, capfd, part, size):
    bench.route()
    assert bench.tick(0) == [0]
    bench.tick(1, "objects" if part == "ego" else "ego")
    bench.node._on_part(part, encode(messages.OBJECTS(header=messages.header_of(0.05)))[:size])
    assert len(bench.commands.got) == 1
    words = f"unusable: {part}: {size} bytes are too few for a header" if size < 12 else "no decision at 0.05 s"
    assert words in capfd.readouterr().err
    assert bench.tick(2) == [2]


def test_the_real_policy_survives_nonsense(domain, tmp_path, monkeypatch):
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path))
    rclpy.init(args=["test"], domain_id=domain)
    node = PolicyNode()
    try:
        there = Bench.__new__(Bench)
        there.node, there.policy = node, node._policy
        there.commands, there.plans = Tape(messages.COMMAND), Tape(messages.TRAJECTORY)
        node._command_publisher, node._trajectory_publisher = there.commands, there.plans
        there.route()
        columns = ("x", "y", "yaw", "speed", "acceleration", "yaw_rate", "length", "width")
        nonsense = messages.OBJECTS(
            id=np.ones(1, dtype=np.uint32),
            kind=np.full(1, 250, dtype=np.uint8),
            **{column: np.full(1, math.nan) for column in columns},
        )
        there.tick(0, objects=nonsense)
        assert there.tick(1) == [1]
        assert messages.command_of(there.commands.got[-1][1]).fault == ""
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


def test_an_unknown_policy_is_refused_by_name(domain, tmp_path, monkeypatch):
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path))
    rclpy.init(args=["test", "--ros-args", "-p", "policy:=autopilot"], domain_id=domain)
    try:
        with pytest.raises(
            InputError,
            match="parameter policy: there is no 'autopilot'; choose one of modular, neural, ego_mlp, deep_sets",
        ):
            PolicyNode()
    finally:
        rclpy.try_shutdown()
