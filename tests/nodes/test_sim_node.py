"""sim_node in this process, with its wall clock and its inputs in the test's hands; SUMO is real."""

import json
import math
import time
from types import SimpleNamespace

import pytest
import rclpy
from nav_msgs.msg import Odometry
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from roadmend_msgs import msg

from roadmend.core.command import Command
from roadmend.core.episode_result import EpisodeResult
from roadmend.core.errors import InputError
from roadmend.core.outcome import EventKind
from roadmend.nodes import qos
from roadmend.nodes import sim as module
from roadmend.nodes.diagnostics import Level
from roadmend.nodes.recorder_progress import LEAD_TICKS
from roadmend.recording import messages, topics
from roadmend.recording.codec import encode
from roadmend.world.obstacle import Obstacle

GO = Command(0.3, 0.0)


class Tape:
    """Stands in for a publisher and keeps what is published, with its stamp [ns]."""

    def __init__(self, kind):
        self._kind, self.got = kind, []

    def publish(self, data):
        self.got.append((messages.stamp_of_bytes(data), self._kind.decode(data)))


class Bench:
    def __init__(self, node, clock):
        self.node, self.clock = node, clock
        self.objects, self.events = Tape(messages.OBJECTS), Tape(messages.EVENT)
        node._objects_publisher, node._event_publisher = self.objects, self.events

    def command(self, number, command=GO):
        self.node._on_command(encode(messages.command_message_of(command, messages.header_of(0.05 * number))))

    def wait(self, duration):
        for _ in range(round(duration / 0.01)):
            self.clock.now += 0.01
            self.node._watch()

    @property
    def tick(self):
        return self.node._tick.number

    @property
    def speed(self):
        return self.node._tick.scene.ego.speed

    @property
    def kinds(self):
        return [EventKind(message.kind) for _, message in self.events.got]

    def drive(self, ticks):
        for _ in range(ticks):
            self.command(self.tick)


@pytest.fixture
def bench(domain, tmp_path, monkeypatch, scenario_file):
    """Makes a node on an empty crossing; unless told otherwise, nobody is waited for."""
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path))
    clock = SimpleNamespace(now=1000.0)
    made = []

    def make(*, time_limit=30.0, waits=False, obstacles=(), **parameters):
        path = scenario_file("S3", 0, actors=[], time_limit=time_limit, obstacles=[*obstacles])
        parameters = {"scenario": str(path)} | parameters
        words = [word for name, value in parameters.items() for word in ("-p", f"{name}:={json.dumps(value)}")]
        rclpy.init(args=["test", "--ros-args", *words], domain_id=domain)
        node = module.SimNode()
        made.append(node)
        monkeypatch.setattr(module, "time", SimpleNamespace(monotonic=lambda: clock.now))
        there = Bench(node, clock)
        if not waits:
            node._missing = list
            node._watch()
        return there

    yield make
    for node in made:
        node.close()
        node.destroy_node()
    rclpy.try_shutdown()


def test_of_a_node_that_must_hear_nothing_it_is_enough_that_it_is_there(bench):
    there = bench(waits=True, wait_for=["beacon_node"])
    assert there.node._missing() == ["beacon_node"]
    beacon = Node("beacon_node")
    try:
        deadline = time.monotonic() + 10.0
        while there.node._missing() and time.monotonic() < deadline:
            time.sleep(0.02)
        assert there.node._missing() == []
    finally:
        beacon.destroy_node()


def test_it_waits_until_the_nodes_have_joined_and_says_for_whom(bench):
    there = bench(waits=True)
    there.wait(1.0)
    assert there.node._tick is None
    health = there.node._health()
    assert health.level is Level.WARN
    assert "policy_node (ego)" in health.message
    assert "repair_node (ego)" in health.message

    policy, repair = Node("policy_node"), Node("repair_node")
    executor = SingleThreadedExecutor()
    try:
        for node in (policy, repair):
            for kind, topic, profile in (
                (Odometry, topics.EGO, qos.STREAM),
                (msg.ObjectList, topics.OBJECTS, qos.STREAM),
                (msg.Route, topics.ROUTE, qos.LATCHED),
            ):
                node.create_subscription(kind, topic, lambda _: None, profile)
        repair.create_subscription(msg.Command, topics.POLICY_COMMAND, lambda _: None, qos.COMMAND)
        repair.create_subscription(msg.Trajectory, topics.POLICY_TRAJECTORY, lambda _: None, qos.STREAM)

        def missing_becomes(expected):
            end = time.monotonic() + 10.0
            while there.node._missing() != expected and time.monotonic() < end:
                executor.spin_once(timeout_sec=0.02)
            return there.node._missing() == expected

        # It must also be ready to answer.
        assert missing_becomes(["repair_node (repair/command)"])
        there.wait(0.05)
        assert there.node._tick is None
        repair.create_publisher(msg.Command, topics.REPAIR_COMMAND, qos.COMMAND)
        assert missing_becomes([])
        there.wait(0.02)
        assert there.tick == 0
        assert there.kinds == [EventKind.STARTED]
        assert there.node._health().level is Level.OK
    finally:
        for node in (policy, repair):
            node.destroy_node()


def test_an_ego_that_stands_in_something_from_the_first_collides_and_is_asked_for_one_command(bench):
    there = bench()
    ego = there.node._tick.scene.ego
    there.node.close()
    rclpy.try_shutdown()

    there = bench(obstacles=[Obstacle(id="wall", x=ego.x, y=ego.y, length=2.0, width=2.0)])
    assert there.tick == 0
    assert not there.node._ended_at
    there.command(0)
    assert there.tick == 0
    assert there.node._ended_at
    assert there.node._builder.result().outcome is EventKind.COLLISION


def test_the_first_tick_is_repeated_until_it_is_answered(bench):
    there = bench()
    there.wait(3.0)
    assert there.tick == 0
    assert {stamp for stamp, _ in there.objects.got} == {0}
    assert 10 <= len(there.objects.got) <= 13
    assert there.kinds == [EventKind.STARTED]  # no watchdog: start-up is a state of its own
    there.command(0)
    assert there.tick == 1


def test_in_lockstep_each_tick_waits_for_its_own_command(bench):
    there = bench()
    there.drive(3)
    for number in (0, 2, 4, 100):
        there.command(number)
        assert there.tick == 3
    there.command(3)
    there.command(3)  # said twice, obeyed once
    assert there.tick == 4
    assert [stamp // 50_000_000 for stamp, _ in there.objects.got] == [0, 1, 2, 3, 4]


def test_the_watchdog_brakes_after_the_timeout_and_lets_go_when_commands_come_again(bench):
    there = bench(command_timeout=0.5)
    there.drive(20)
    before = there.speed
    there.wait(0.45)
    assert there.tick == 20
    there.wait(0.1)
    assert there.tick == 21
    assert there.kinds[-1] is EventKind.WATCHDOG
    assert there.node._health().level is Level.ERROR
    there.wait(1.2)  # from now on impatient: 0.05 s a tick
    assert 38 <= there.tick <= 46
    bitten = there.tick - 20
    assert there.kinds.count(EventKind.WATCHDOG) == 1  # said once
    assert before - 5.0 * 0.05 * bitten - 0.5 <= there.speed <= before - 2.0 * 0.05 * bitten
    there.command(there.tick)
    assert there.kinds[-1] is EventKind.RECOVERED
    assert there.node._watchdog_ticks == bitten
    assert there.node._health().level is Level.OK
    there.wait(0.45)
    assert there.tick == 20 + bitten + 1  # patient again


@pytest.mark.parametrize(
    "command",
    [Command(math.nan, 0.0), Command(0.0, math.inf), Command(0.4, 0.4), Command(1.1, 0.0), Command(0.0, -0.1)],
)
@pytest.mark.parametrize("clock", ["lockstep", "realtime"])
def test_an_invalid_command_is_refused(bench, command, clock):
    there = bench(clock=clock)
    there.command(0, command)
    assert there.tick == 0
    assert there.node._last_command is None
    there.command(0)
    if clock == "realtime":
        there.node._beat()
    assert there.tick == 1


@pytest.mark.parametrize("size", [0, 4, 11, 24])
@pytest.mark.parametrize("clock", ["lockstep", "realtime"])
def test_bytes_that_are_no_command_are_as_good_as_none(bench, capfd, clock, size):
    there = bench(clock=clock, command_timeout=0.5)
    there.command(0)
    if clock == "realtime":
        there.node._beat()
    whole = encode(messages.command_message_of(GO, messages.header_of(0.05)))
    assert len(whole) > 24
    for _ in range(20):
        there.node._on_command(whole[:size])
        there.wait(0.05)
        if clock == "realtime":
            there.node._beat()
    assert there.kinds == [EventKind.STARTED, EventKind.WATCHDOG]
    assert "refused a command: the bytes are no roadmend_msgs/msg/Command" in capfd.readouterr().err
    there.command(there.tick)
    if clock == "realtime":
        there.node._beat()
    assert there.kinds[-1] is EventKind.RECOVERED


def test_in_real_time_the_vehicle_is_held_until_the_first_command(bench):
    there = bench(clock="realtime")
    speed = there.speed
    for _ in range(20):
        there.clock.now += 0.05
        there.node._beat()
    assert (there.tick, there.speed) == (0, speed)
    assert 4 <= len(there.objects.got) <= 5  # it says so again, but not at every beat
    assert there.kinds == [EventKind.STARTED]


def test_in_real_time_no_command_older_than_three_ticks_is_used(bench):
    there = bench(clock="realtime")
    there.command(0)
    for number in (1, 2, 3, 4):
        before = there.speed
        there.node._beat()
        assert there.tick == number
        assert there.speed > before  # of tick 0, up to three ticks old
    assert EventKind.WATCHDOG not in there.kinds
    before = there.speed
    there.node._beat()
    assert there.speed < before
    assert there.kinds[-1] is EventKind.WATCHDOG
    there.command(1)  # too old to help
    there.node._beat()
    assert there.kinds[-1] is EventKind.WATCHDOG
    there.command(there.tick)
    there.node._beat()
    assert there.kinds[-1] is EventKind.RECOVERED
    assert there.node._watchdog_ticks == 2


def test_in_real_time_an_older_command_never_replaces_a_newer_one(bench):
    there = bench(clock="realtime")
    there.command(0)
    there.node._beat()
    there.node._beat()
    there.command(2, Command(0.0, 1.0))
    there.command(1, GO)
    assert there.node._last_command[1] == Command(0.0, 1.0)


@pytest.mark.parametrize("ahead", [1, 40])
def test_in_real_time_a_command_from_the_future_is_refused(bench, ahead):
    """Obeyed, it would count as fresh for as long as its stamp lies ahead, and shut out all others."""
    there = bench(clock="realtime")
    there.command(0)
    there.node._beat()
    there.command(there.tick + ahead, Command(1.0, 0.0))
    assert there.node._last_command == (0, GO)


def test_the_end_is_announced_written_down_and_lingered_for(bench, tmp_path):
    there = bench(time_limit=0.5, summary=str(tmp_path / "sim.json"))
    there.drive(10)
    assert there.kinds[-1] is EventKind.TIMEOUT
    told = EpisodeResult.parse(json.loads((tmp_path / "sim.json").read_text())["result"])
    assert (told.outcome, told.ticks, told.duration) == (EventKind.TIMEOUT, 10, 0.5)
    assert told.min_distance is None  # nobody was there
    assert len(told.digest) == 64
    assert not there.node.finished
    there.command(10)
    there.node._beat()
    assert there.tick == 10
    there.wait(0.4)
    assert there.node.finished
    there.node.close()
    assert EventKind.ABORTED not in there.kinds


def test_an_episode_that_is_stopped_is_recorded_as_aborted(bench, tmp_path):
    there = bench(summary=str(tmp_path / "sim.json"))
    there.drive(4)
    there.node.close()
    assert there.kinds[-1] is EventKind.ABORTED
    told = json.loads((tmp_path / "sim.json").read_text())["result"]
    assert EpisodeResult.parse(told).outcome is EventKind.ABORTED


@pytest.mark.parametrize(
    ("parameters", "words"),
    [
        ({"scenario": "/nowhere/s.yaml"}, "/nowhere/s.yaml: no such file"),
        ({"clock": "sundial"}, "parameter clock"),
        ({"rate": 0.0}, "parameter rate"),
        ({"command_timeout": "long"}, "parameter command_timeout"),
        ({"scenario": ""}, "parameter scenario: is empty"),
    ],
)
def test_bad_parameters_are_refused_by_name(bench, parameters, words):
    with pytest.raises(InputError, match=words):
        bench(**parameters)


def report(bench, number):
    bench.node._progress._hear(messages.stamp_message_of(number * 50_000_000))


def test_in_lockstep_a_command_is_held_until_the_recorder_has_caught_up(bench):
    there = bench()
    there.wait(0.01)
    report(there, 0)
    there.drive(LEAD_TICKS)
    assert there.tick == LEAD_TICKS
    there.command(LEAD_TICKS)
    there.wait(1.0)
    assert there.tick == LEAD_TICKS
    assert there.kinds == [EventKind.STARTED]  # nobody brakes: the command is there
    report(there, 5)
    assert there.tick == LEAD_TICKS + 1


def test_in_lockstep_a_recorder_that_writes_nothing_more_is_not_waited_for_for_ever(bench):
    there = bench(command_timeout=2.0)
    there.wait(0.01)
    report(there, 0)
    there.drive(LEAD_TICKS + 1)
    there.wait(1.9)
    assert there.tick == LEAD_TICKS
    there.wait(0.2)
    assert there.tick == LEAD_TICKS + 1
    there.drive(3 * LEAD_TICKS)
    assert there.tick == 4 * LEAD_TICKS + 1
    assert EventKind.WATCHDOG not in there.kinds


def test_in_real_time_nobody_waits_for_the_recorder(bench):
    there = bench(clock="realtime")
    there.wait(0.01)
    report(there, 0)
    for _ in range(3 * LEAD_TICKS):
        there.command(there.tick)
        there.node._beat()
    assert there.tick == 3 * LEAD_TICKS
