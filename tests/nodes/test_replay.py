"""replay_node: in this process with its wall clock in the test's hands, and over DDS beside real nodes."""

import json
import math
import os
import time
from types import SimpleNamespace

import numpy as np
import pytest
import rclpy
from builtin_interfaces.msg import Time
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.serialization import serialize_message
from roadmend_msgs import msg
from std_msgs.msg import String
from std_srvs.srv import Trigger

from roadmend.nodes import replay as module
from roadmend.nodes.children import Child, stop
from roadmend.nodes.graph_options import GraphOptions
from roadmend.nodes.launcher import run_graph
from roadmend.recording import messages
from roadmend.recording.codec import encode
from roadmend.recording.definitions import Definition, find
from roadmend.recording.qos import Qos
from roadmend.recording.reader import BagReader
from roadmend.recording.writer import BagWriter
from roadmend.world.families import sample_scenario
from roadmend.world.scenario_file import save_scenario

TICK_NS = 50_000_000
COUNT = 6
LATCHED = Qos(history="unknown", depth=0, durability="transient_local")


def command(tick):
    return encode(messages.COMMAND(header=messages.header_of(0.05 * tick), throttle=0.1))


@pytest.fixture
def bag(tmp_path):
    """Six ticks on /policy/command, the same on /repair/command, a latched /note at the first, a type nobody has."""
    path = tmp_path / "bag"
    with BagWriter(path) as writer:
        writer.add_topic("/note", "std_msgs/msg/String", [LATCHED])
        writer.add_topic("/policy/command", "roadmend_msgs/msg/Command", [Qos(depth=1, deadline_ns=500_000_000)])
        writer.add_topic("/repair/command", "roadmend_msgs/msg/Command", [Qos(depth=1)])
        writer.add_topic("/strange", "absent_msgs/msg/None", (), Definition("absent_msgs/msg/None", "int32 data\n", ""))
        writer.write("/note", 0, serialize_message(String(data="begin")))
        writer.write("/strange", 0, command(0))
        for tick in range(COUNT):
            writer.write("/policy/command", tick * TICK_NS, command(tick))
            writer.write("/repair/command", tick * TICK_NS, command(tick))
    return path


class Tape:
    """Stands before a publisher and keeps what it lets through."""

    def __init__(self, name, publisher, got):
        self._name, self._publisher, self._got = name, publisher, got
        self.count = 1

    def publish(self, message):
        self._got.append((self._name, message))

    def get_subscription_count(self):
        return self.count

    def __getattr__(self, name):
        return getattr(self._publisher, name)


class Bench:
    """A replay node whose wall clock and whose listeners are in the test's hands."""

    def __init__(self, node, clock):
        self.node, self.clock, self.got = node, clock, []
        players = node._players.publishers
        players |= {name: Tape(name, publisher, self.got) for name, publisher in players.items()}

    def wait(self, duration):
        """Let wall time pass; returns the ticks of the policy's commands published meanwhile."""
        before = len(self.got)
        for _ in range(round(duration / 0.01)):
            self.clock.now += 0.01
            self.node._beat()
        return self.ticks(before)

    def begin(self):
        for _ in range(100):
            if self.node._begun:
                return
            self.wait(0.01)

    def ticks(self, begin=0):
        commands = [data for name, data in self.got[begin:] if name == "/policy/command"]
        return [module.stamp_of_bytes(data) // TICK_NS for data in commands]

    def call(self, name):
        return getattr(self.node, f"_on_{name}")(Trigger.Request(), Trigger.Response())

    def answer(self, tick, topic="/repair/command"):
        self.node._on_answer(topic, command(tick))


def words(**parameters):
    return [word for name, value in parameters.items() for word in ("-p", f"{name}:={json.dumps(value)}")]


@pytest.fixture
def bench(bag, domain, tmp_path, monkeypatch):
    """Makes a node with parameters and other ROS arguments; at its end all is gone."""
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path))
    clock = SimpleNamespace(now=1000.0)
    made = []

    def make(*arguments, **parameters):
        given = words(**{"bag": str(bag), **parameters})
        rclpy.init(args=["test", "--ros-args", *given, *arguments], domain_id=domain)
        made.append(module.ReplayNode())
        monkeypatch.setattr(module, "time", SimpleNamespace(monotonic=lambda: clock.now))
        return Bench(made[0], clock)

    yield make
    for node in made:
        node.destroy_node()
    rclpy.try_shutdown()


# -- on the wall clock -------------------------------------------------------------------------------------------------


def test_it_plays_at_its_rate_once_nobody_is_joining_any_more(bench):
    there = bench(rate=0.5)
    assert there.wait(0.4) == []
    there.node._players.publishers["/note"].count += 1  # somebody joins
    assert there.wait(0.4) == []
    there.begin()
    assert there.wait(0.17) == [1]  # the first was played when it began
    assert there.wait(0.22) == [2, 3]
    there.node.set_parameters([rclpy.Parameter("rate", value=5.0)])
    assert there.wait(0.05) == [4, 5]
    assert there.node.finished
    assert there.node.exit_code == 0
    assert [name for name, _ in there.got].count("/note") == 1


def test_a_rate_that_is_not_above_zero_is_refused_while_it_plays(bench):
    node = bench().node
    for wrong in (0.0, -1.0, math.nan, math.inf):
        (result,) = node.set_parameters([rclpy.Parameter("rate", value=wrong)])
        assert not result.successful
        assert "rate" in result.reason


def test_it_waits_for_the_nodes_that_must_listen(bench, domain):
    there = bench(wait_for=["listener"])
    assert there.wait(3.0) == []
    assert "waiting for listener" in there.node._health().message
    listener = Node("listener")
    listener.create_subscription(msg.Command, "policy/command", lambda _: None, 1)
    for _ in range(100):
        if not there.node._missing():
            break
        time.sleep(0.02)
    there.begin()
    assert there.node._begun
    listener.destroy_node()


def test_it_waits_for_a_listener_on_every_topic_where_it_is_to(bench):
    there = bench(wait_for_listeners=True)
    there.node._players.publishers["/note"].count = 0
    assert there.wait(3.0) == []
    assert there.node._missing() == ["a listener on /note"]
    there.node._players.publishers["/note"].count = 1
    there.begin()
    assert there.node._begun


def test_it_begins_again_at_the_end_where_it_is_to_loop(bench):
    there = bench(loop=True, rate=10.0)
    there.begin()
    there.wait(0.2)
    ticks = there.ticks()
    assert ticks[: 2 * COUNT] == [*range(COUNT)] * 2
    assert not there.node.finished


def test_in_every_round_the_latched_messages_come_first(bench):
    there = bench(start_offset=0.2, loop=True, rate=10.0)
    there.begin()
    there.wait(0.2)
    notes = [data for topic, data in there.got if topic == "/note"]
    assert len(notes) > 1
    assert {*notes} == {serialize_message(String(data="begin"))}


def test_an_offset_brings_the_latched_messages_first(bench):
    there = bench(start_offset=0.2)
    there.begin()
    there.wait(0.2)
    assert there.ticks() == [4, 5]
    assert there.got[0] == ("/note", serialize_message(String(data="begin")))


def test_topics_that_are_silent_after_the_offset_are_refused(bench, capfd):
    there = bench(topics=["note"], start_offset=0.1, loop=True)
    there.wait(1.0)
    assert (there.node.finished, there.node.exit_code) == (True, 2)
    assert "no message of the topics to play comes after it; begin earlier" in capfd.readouterr().err


def test_pause_step_resume_toggle(bench):
    there = bench(start_paused=True)
    refused = there.call("step")
    assert not refused.success
    assert refused.message == "not begun: waiting for the graph to settle"
    there.begin()
    assert there.wait(1.0) == []
    assert (there.call("step").message, there.call("step").message) == ("0.000 s", "0.050 s")
    assert there.ticks() == [0, 1]
    assert there.wait(1.0) == []
    assert there.call("resume").message == "playing"
    assert there.wait(0.12) == [2, 3]
    refused = there.call("step")
    assert (refused.success, refused.message) == (False, "playing: pause first")
    assert there.call("toggle_paused").message == "paused"
    assert there.wait(1.0) == []
    assert there.call("pause").success
    assert "paused" in there.node._health().message
    assert there.call("step").success
    assert there.call("step").success
    assert there.ticks() == [*range(COUNT)]
    refused = there.call("step")
    assert (refused.success, refused.message) == (False, "the bag is at its end")
    assert there.node.finished


def test_a_bag_that_is_broken_further_on_ends_the_replay_with_its_line(bench, bag, capfd):
    there = bench()
    (file,) = bag.glob("*.mcap")
    content = file.read_bytes()
    file.write_bytes(content.replace(content[60:90], bytes(30)))
    there.begin()
    there.wait(1.0)
    assert (there.node.finished, there.node.exit_code) == (True, 2)
    assert "was cut short or is corrupt" in capfd.readouterr().err


@pytest.mark.parametrize(("latched", "time"), [("transient_local", -1), ("volatile", 2 * TICK_NS)])
def test_bytes_that_are_no_message_end_the_replay_with_a_line(bench, tmp_path, capfd, latched, time):
    other = tmp_path / "other"
    with BagWriter(other) as writer:
        writer.add_topic("/note", "std_msgs/msg/Bool", [Qos(depth=1, durability=latched)])
        writer.add_topic("/policy/command", "roadmend_msgs/msg/Command", [Qos(depth=1)])
        writer.write("/note", max(time, 0), b"(\xb5/\xfd" + bytes(60))  # as zstd begins
        for tick in range(COUNT):
            writer.write("/policy/command", tick * TICK_NS, command(tick))
    there = bench(bag=str(other), start_offset=0.0 if time > 0 else 0.1)
    there.node._players.publishers["/note"] = there.node._players.publishers["/note"]._publisher
    there.begin()
    there.wait(1.0)
    assert (there.node.finished, there.node.exit_code) == (True, 2)
    assert f"{other}: a message on /note is not a std_msgs/msg/Bool; take another bag" in capfd.readouterr().err


# -- topics ------------------------------------------------------------------------------------------------------------


def offered(node, topic):
    (info,) = node.get_publishers_info_by_topic(topic)
    return info.qos_profile


def test_topics_are_offered_as_recorded_and_what_cannot_be_played_is_named(bench):
    node = bench().node
    assert offered(node, "/note").durability.name == "TRANSIENT_LOCAL"
    assert offered(node, "/policy/command").deadline.nanoseconds == 500_000_000
    assert offered(node, "/repair/command").durability.name == "VOLATILE"
    health = node._health().values
    assert health["not played: /strange"].startswith("absent_msgs/None: no such message type is installed")


def test_topics_follow_the_namespace_and_remaps_but_the_clock_is_one_for_all(bench):
    node = bench("-r", "__ns:=/old", "-r", "policy/command:=wish").node
    names = {name for name, types in node.get_topic_names_and_types() if types[0].startswith(("road", "std", "rosg"))}
    assert {"/clock", "/old/note", "/old/wish", "/old/repair/command"} <= names
    assert "/policy/command" not in names


def test_a_bag_without_a_clock_is_played_with_one(bench, bag):
    there = bench(topics=["note"])
    times = []
    there.node._clock_publisher = SimpleNamespace(publish=lambda message: times.append(message.clock))
    there.begin()
    there.wait(1.0)
    assert [(name, time.sec, time.nanosec) for (name, _), time in zip(there.got, times, strict=True)] == [
        ("/note", 0, 0)
    ]


def test_the_clock_can_be_excluded(bench):
    node = bench(exclude=["/clock", "/note"]).node
    assert not node._makes_clock
    assert not node.count_publishers("/clock")
    assert "/note" not in node._players.publishers


# -- in lockstep -------------------------------------------------------------------------------------------------------


@pytest.fixture
def answered(bench, monkeypatch):
    """A node in lockstep that has begun; somebody answers."""
    monkeypatch.setattr(module.ReplayNode, "_answered", lambda *_: True)
    there = bench(clock="lockstep", answers=["repair/command"])
    there.begin()
    return there


def test_each_tick_waits_for_the_answers_to_the_one_before(answered):
    assert answered.ticks() == [0]
    assert "waiting for an answer on /repair/command" in answered.node._health().message
    answered.answer(3)  # to another tick
    assert answered.ticks() == [0]
    for tick in range(COUNT):
        answered.answer(tick)
        answered.answer(tick)  # twice is once
    assert answered.ticks() == [*range(COUNT)]
    assert answered.node.finished
    assert "/repair/command" not in [name for name, _ in answered.got]


@pytest.mark.parametrize("size", [0, 4, 11])
def test_bytes_that_are_too_few_for_a_stamp_answer_nothing_and_end_nothing(answered, size):
    answered.node._on_answer("/repair/command", command(0)[:size])
    assert answered.ticks() == [0]
    answered.answer(0)
    assert answered.ticks() == [0, 1]


def test_an_unanswered_tick_is_repeated_without_what_is_latched(answered):
    assert answered.wait(1.0) == [0, 0, 0]
    assert [name for name, _ in answered.got].count("/note") == 1


def test_a_pause_holds_the_tick_after_the_answer(answered):
    answered.call("pause")
    refused = answered.call("step")
    assert (refused.success, refused.message) == (False, "waiting for an answer on /repair/command")
    answered.answer(0)
    assert answered.ticks() == [0]
    assert answered.call("step").success
    assert answered.ticks() == [0, 1]


def test_an_answer_that_never_comes_ends_the_replay(answered, capfd):
    answered.wait(30.0)
    assert not answered.node.finished  # the first one may take its time
    answered.answer(0)
    answered.wait(10.2)
    assert (answered.node.finished, answered.node.exit_code) == (True, 1)
    assert "no answer on /repair/command to the tick at 0.05 s in 10.0 s" in capfd.readouterr().err


def test_a_tick_waits_for_a_recorder_that_is_behind_but_not_for_ever(answered, capfd):
    answered.node._recorder._newest_ns = -2 * 10**9  # two seconds before the first tick
    answered.answer(0)
    assert answered.ticks() == [0]
    assert answered.wait(1.0) == []
    answered.node._recorder._hear(Time(sec=0, nanosec=0))
    assert answered.ticks() == [0, 1]
    answered.node._recorder._newest_ns = -2 * 10**9
    answered.answer(1)
    assert answered.wait(9.0) == []
    assert answered.wait(1.1) == [2]
    assert "the recorder has written nothing for 10 s: it goes on without it" in capfd.readouterr().err


def test_it_waits_until_somebody_can_answer(bench):
    there = bench(clock="lockstep", answers=["repair/command"])
    assert there.wait(3.0) == []
    assert there.node._missing() == ["a node that answers on /repair/command"]


# -- bad input ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("parameters", "line"),
    [
        ({"bag": "nowhere"}, "nowhere: there is no such bag"),
        ({"rate": 0.0}, "parameter rate: Invalid parameter value (0.0)"),
        ({"rate": -1.0}, "parameter rate: Invalid parameter value (-1.0)"),
        ({"start_offset": 1.0}, "start: 1 s is outside the bag; give a time from 0 to 0.25 s"),
        ({"start_offset": -1.0}, "parameter start_offset: Invalid parameter value (-1.0)"),
        ({"topics": ["/nothing"]}, "topic /nothing: is not in"),
        ({"exclude": ["/nothing"]}, "topic /nothing: is not in"),
        ({"topics": ["/strange"]}, "no topic can be played; absent_msgs/None: no such message type is installed"),
        ({"clock": "sundial"}, "parameter clock: 'sundial' is not allowed; choose one of realtime, lockstep"),
        ({"clock": "lockstep"}, "topic /repair/state: is not in"),
        ({"clock": "lockstep", "answers": ["/note"]}, "answers /note: std_msgs/msg/String has no header"),
    ],
)
def test_bad_input_is_one_line_and_code_2(bag, domain, tmp_path, monkeypatch, capfd, parameters, line):
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path))
    given = words(**{"bag": str(bag), **parameters})
    assert module.main(["replay_node", "--ros-args", "--log-level", "error", *given]) == 2
    (said,) = capfd.readouterr().err.splitlines()
    assert said.startswith("roadmend: ")
    assert line in said


# -- over DDS ----------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A recorded run that is repaired."""
    folder = tmp_path_factory.mktemp("run")
    scenario = sample_scenario("S3", 3).model_copy(update={"time_limit": 8.0})
    save_scenario(scenario, folder / "s.yaml")
    result = run_graph(GraphOptions(folder / "s.yaml", method="predictive", bags=folder, name="run", viz=False))
    return folder / "run", result.episode


@pytest.fixture
def beside(domain, tmp_path):
    """Starts node processes; they end with the test."""
    children = []

    def start(node, **parameters):
        child = Child(
            f"{node}_node",
            f"roadmend.nodes.{node}",
            ["--ros-args", *words(**parameters)],
            {key: os.environ[key] for key in ("ROS_DOMAIN_ID", "ROS_AUTOMATIC_DISCOVERY_RANGE")},
            tmp_path / f"{node}.log",
            may_restart=False,
        )
        child.start()
        children.append(child)
        return child

    yield start
    stop(children, time.monotonic() + 5.0)


def finish(child):
    child.process.join(120)
    assert child.exit_code == 0, child.log.read_text()


def by_stamp(bag, topic):
    return {messages.stamp_of(one.value.header): one.value for one in BagReader(bag).messages([topic])}


def same(one, other):
    """Whether two decoded messages are equal bit for bit."""
    if hasattr(one, "__msgtype__"):
        return all(same(getattr(one, name), getattr(other, name)) for name in one.__dataclass_fields__)
    return np.array_equal(one, other, equal_nan=isinstance(one, float | np.ndarray))


@pytest.mark.graph
def test_a_run_replayed_into_repair_node_gives_the_recorded_decisions_bit_for_bit(run, beside, tmp_path):
    bag, result = run
    assert result.interventions > 0
    beside("repair", method="predictive", input_timeout=60.0)  # a starved process is not what is tested
    recorder = beside("recorder", output=str(tmp_path), name="again", drain_limit=60.0)
    finish(beside("replay", bag=str(bag), clock="lockstep", wait_for=["repair_node"], wait_for_listeners=True))
    stop([recorder], time.monotonic() + 90.0)
    for topic in ("/repair/state", "/repair/command"):
        then, now = by_stamp(bag, topic), by_stamp(tmp_path / "again", topic)
        assert len(then) >= result.ticks
        assert then.keys() <= now.keys()
        assert [(message, now[stamp]) for stamp, message in then.items() if not same(message, now[stamp])] == []


@pytest.mark.graph
def test_at_rate_10_order_stamps_and_bytes_are_kept(run, beside, tmp_path):
    bag, _ = run
    recorder = beside("recorder", output=str(tmp_path), name="again", drain_limit=1.0)
    finish(beside("replay", bag=str(bag), rate=10.0, wait_for_listeners=True))
    stop([recorder], time.monotonic() + 90.0)
    then, now = BagReader(bag), BagReader(tmp_path / "again")
    for topic in then.topics.keys() - {
        "/rosout",
        "/diagnostics",
        "/configuration",
    }:  # the replayer and the recorder speak there too
        assert [(one.time_ns, one.data) for one in now.records([topic])] == [
            (one.time_ns, one.data) for one in then.records([topic])
        ], topic
        assert find(now.topics[topic].type_name).type_hash == now.topics[topic].type_hash


@pytest.mark.graph
def test_the_services_are_there_under_the_nodes_name(bag, beside, domain):
    replay = beside("replay", bag=str(bag), start_paused=True)
    rclpy.init(domain_id=domain)
    node, executor = Node("caller"), SingleThreadedExecutor()
    executor.add_node(node)
    heard = []
    node.create_subscription(msg.Command, "policy/command", heard.append, 10)
    try:
        clients = {name: node.create_client(Trigger, f"replay_node/{name}") for name in ("step", "resume", "pause")}
        assert all(client.wait_for_service(30.0) for client in clients.values())

        def call(name):
            future = clients[name].call_async(Trigger.Request())
            while not future.done():
                executor.spin_once(timeout_sec=0.1)
            return future.result()

        while not call("step").success:  # until it has begun
            executor.spin_once(timeout_sec=0.1)
        assert call("pause").message == "paused"
        assert call("step").message == "0.050 s"
        assert call("resume").message == "playing"
        while len(heard) < COUNT:
            executor.spin_once(timeout_sec=0.1)
    finally:
        node.destroy_node()
        rclpy.try_shutdown()
    assert [messages.stamp_of(message.header) // TICK_NS for message in heard] == [*range(COUNT)]
    finish(replay)
