"""The live server, seen by a client that is made of Foxglove's own libraries, in a graph that drives."""

import contextlib
import json
import queue
import shutil
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
import rclpy
from builtin_interfaces.msg import Time
from roadmend_msgs.msg import Command
from rosgraph_msgs.msg import Clock as ClockMessage
from std_msgs.msg import Float64

from roadmend.core.errors import InputError
from roadmend.nodes.graph_options import GraphOptions
from roadmend.nodes.launcher import run_graph
from roadmend.recording.definitions import find

pytestmark = pytest.mark.graph

NPM = Path(__file__).parents[1] / "npm"
PATIENCE_S = 60.0
THRESHOLD = "/repair_node.adreft.threshold"


def free_port():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        return taken.getsockname()[1]


class Client:
    """A client process; what it has heard can be waited for."""

    def __init__(self, port, origin="", protocol=""):
        command = ["node", "foxglove_client.mjs", f"ws://127.0.0.1:{port}", origin, protocol]
        self.process = subprocess.Popen(
            command, cwd=NPM, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1
        )
        self.heard = queue.Queue()
        threading.Thread(target=self._listen, daemon=True).start()

    def _listen(self):
        for line in self.process.stdout:
            self.heard.put(json.loads(line))

    def ask(self, **command):
        self.process.stdin.write(json.dumps(command) + "\n")

    def wait(self, event, test=lambda _: True):
        """The next thing heard of this kind that passes the test; what comes before is dropped."""
        end = time.monotonic() + PATIENCE_S
        while True:
            heard = self.heard.get(timeout=max(0.0, end - time.monotonic()))
            if heard["event"] == event and test(heard):
                return heard

    def wait_all(self, event, **wanted):
        """One of each, in whatever order they come."""
        found = {}
        while len(found) < len(wanted):
            heard = self.wait(event)
            found |= {name: heard for name, test in wanted.items() if name not in found and test(heard)}
        return found

    def wait_while(self, publish):
        """The first message that comes while something publishes again and again; whatever else is said fails at once."""
        end = time.monotonic() + PATIENCE_S
        while time.monotonic() < end:
            publish()
            with contextlib.suppress(queue.Empty):
                heard = self.heard.get(timeout=0.1)
                if heard["event"] == "message":
                    return heard
                assert heard["event"] in {"channel", "time"}
        pytest.fail("no message came")

    def close(self):
        self.process.kill()
        self.process.communicate()


@pytest.fixture
def connect():
    if shutil.which("node") is None or not (NPM / "node_modules" / "ws").is_dir():
        pytest.skip("node or tests/npm/node_modules is not there")
    clients = []

    def make(port, origin="", protocol=""):
        clients.append(Client(port, origin, protocol))
        return clients[-1]

    yield make
    for client in clients:
        client.close()


@pytest.fixture
def live(scenario_file):
    """The port of a graph that drives in real time for a long while."""
    port = free_port()
    path = scenario_file("S3", 3, time_limit=300.0)
    command = [
        sys.executable,
        "-m",
        "roadmend.cli",
        "run",
        "--scenario",
        str(path),
        "--no-record",
        "--repair",
        "adreft",
    ]
    command += ["--clock", "realtime", "--rate", "0.1", "--foxglove", str(port)]
    run = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    for _ in range(600):
        with socket.socket() as trial:
            if trial.connect_ex(("127.0.0.1", port)) == 0:
                break
        time.sleep(0.1)
    yield port
    run.terminate()
    _, said = run.communicate(timeout=30)
    assert f"live at ws://127.0.0.1:{port}" in said


def test_topics_messages_and_parameters_reach_a_client_and_a_new_threshold_reaches_the_repair_node(live, connect):
    client = connect(live)
    assert client.wait("serverInfo")["capabilities"] == ["parameters", "parametersSubscribe", "time"]

    topics = ("/ego", "/map", "/repair/state", "/markers/objects", "/tf", "/diagnostics", "/clock")
    channels = client.wait_all("channel", **{name: lambda heard, name=name: heard["topic"] == name for name in topics})
    for channel in channels.values():
        assert (channel["encoding"], channel["schemaEncoding"]) == ("cdr", "ros2msg")
        assert channel["schema"] == find(channel["schemaName"]).text
    assert channels["/ego"]["schemaName"] == "nav_msgs/msg/Odometry"

    client.ask(subscribe="/map")  # sent once, long ago
    assert len(client.wait("message")["value"]["lane_kind"]) > 3
    client.ask(subscribe="/ego")
    first = client.wait("message", lambda heard: int(heard["time"]) > 0)  # the very first tick may be repeated
    second = client.wait("message")
    stamp = second["value"]["header"]["stamp"]
    assert int(second["time"]) == stamp["sec"] * 10**9 + stamp["nanosec"]  # simulation time
    assert int(second["time"]) - int(first["time"]) == 50_000_000
    assert abs(int(client.wait("time")["timestamp"]) - int(second["time"])) < 10**9
    client.ask(unsubscribe="/ego")

    client.ask(get=[])
    known = {one["name"]: one["value"] for one in client.wait("parameters")["parameters"]}
    assert known[THRESHOLD] == -1
    assert known["/viz_node.rate"] == 10
    client.ask(subscribe="/repair/state", watch=[THRESHOLD])
    states = (heard["value"] for heard in iter(lambda: client.wait("message"), None) if heard["topic"] != "/ego")
    assert next(state["threshold"] for state in states if state["threshold"] != "NaN") < 1.0
    client.ask(set={THRESHOLD: 1})  # a whole number, as JSON has it
    after = client.wait("parameters", lambda heard: heard.get("id") == "set")["parameters"]
    assert [(one["name"], one["value"]) for one in after] == [(THRESHOLD, 1)]
    assert client.wait("message", lambda heard: heard["value"]["threshold"] == 1.0)

    wrong = {THRESHOLD: 7, "/repair_node.method": "rss", "/repair_node.adreft.nothing": 1, "/sim_node.rate": 2}
    wrong["/viz_node.text_radius"] = "far"
    client.ask(set=wrong)
    said = client.wait_all(
        "status", **{name: lambda heard, name=name: heard["id"] == name and heard["level"] == 1 for name in wrong}
    )
    for name, reason in {
        THRESHOLD: "out of range",
        "/repair_node.method": "read-only",
        "/repair_node.adreft.nothing": "no such parameter",
        "/sim_node.rate": "there are /repair_node, /viz_node",
        "/viz_node.text_radius": "'far' is no double",
    }.items():
        assert reason in said[name]["message"]
    after = client.wait("parameters", lambda heard: heard.get("id") == "set")["parameters"]
    assert {one["name"]: one["value"] for one in after} == {
        THRESHOLD: 1,
        "/repair_node.method": "adreft",
        "/viz_node.text_radius": 40,
    }
    client.ask(set={THRESHOLD: 0.5})
    assert client.wait("removeStatus")["statusIds"] == [THRESHOLD]

    # What others change is shown too.
    other = connect(live)
    other.wait("serverInfo")
    other.ask(set={THRESHOLD: 0.25})
    client.wait(
        "parameters", lambda heard: {"name": THRESHOLD, "value": 0.25}.items() <= heard["parameters"][0].items()
    )

    page = connect(live, "https://evil.example")
    assert "403" in page.wait("error")["text"]
    assert connect(live, "https://app.foxglove.dev").wait("serverInfo")["name"] == "roadmend"


def test_a_port_in_use_stops_the_run_with_one_line(scenario_file, tmp_path, domain):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        options = GraphOptions(scenario_file("S1", 0), bags=tmp_path, name="bag", viz=False, foxglove=port)
        with pytest.raises(InputError) as caught:
            run_graph(options)
    assert str(caught.value) == f"127.0.0.1:{port}: is in use; choose another port or address"
    assert not (tmp_path / "bag").exists()


@pytest.fixture
def server(domain):
    """The node by hand, in a namespace; its port."""
    command = [sys.executable, "-m", "roadmend.nodes.foxglove", "--ros-args", "-p", "port:=0", "-r", "__ns:=/car"]
    node = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    told = next(line for line in node.stderr if "ws://127.0.0.1:" in line)
    yield int(told.partition("ws://127.0.0.1:")[2].split()[0])
    node.terminate()
    node.communicate(timeout=30)
    assert node.returncode == 0


def test_topics_appear_as_they_are_published_and_time_that_runs_backwards_begins_a_new_session(server, connect):
    client = connect(server)
    session = client.wait("serverInfo")["sessionId"]
    rclpy.init()
    try:
        node = rclpy.create_node("talker")
        to_clock = node.create_publisher(ClockMessage, "/clock", 10)
        client.wait("channel", lambda heard: heard["topic"] == "/clock")
        context = rclpy.Context()
        rclpy.init(context=context)
        other = rclpy.create_node("other", context=context)
        odd = [each.create_publisher(kind, "/odd", 10) for each, kind in ((node, Float64), (other, ClockMessage))]
        time.sleep(1.0)
        other.destroy_node()  # of two types it is not shown, and of one it is
        rclpy.shutdown(context=context)
        client.wait("channel", lambda heard: heard["topic"] == "/odd")
        gap = node.create_publisher(Float64, "/gap", 10)
        client.wait("channel", lambda heard: heard["topic"] == "/gap")
        client.ask(subscribe="/gap")
        heard_at = []
        for second in (5, 6, 1):
            while not heard_at or heard_at[-1] != second:
                to_clock.publish(ClockMessage(clock=Time(sec=second)))
                gap.publish(Float64(data=0.5))
                with contextlib.suppress(queue.Empty):
                    while True:
                        heard = client.heard.get(timeout=0.1)
                        if heard["event"] == "message":
                            assert heard["value"] == {"data": 0.5}
                            heard_at.append(
                                int(heard["time"]) // 10**9
                            )  # without a stamp, it belongs to the clock's time
                        elif heard["event"] == "serverInfo":
                            assert heard["sessionId"] != session
                            session = ""
        assert set(heard_at) <= {0, 5, 6, 1}
        assert session == ""
        client.ask(get=[])
        assert client.wait("parameters")["parameters"] == []  # there is no node of those it asks
        client.ask(set={"/car/repair_node.rss.rho": 1.0})
        assert "is not there" in client.wait("status")["message"]
        assert odd
    finally:
        rclpy.try_shutdown()


@pytest.fixture
def gap():
    """A node, and its first publisher of a number that changes nothing else."""
    rclpy.init()
    node = rclpy.create_node("talker")
    yield node, node.create_publisher(Float64, "/gap", 10)
    rclpy.try_shutdown()


def subscribed(client):
    """The same client, once it was told of /gap and has asked for it."""
    client.wait("channel", lambda heard: heard["topic"] == "/gap")
    client.ask(subscribe="/gap")
    return client


# The older name is what Lichtblick and the client library of the protocol's own authors offer.
@pytest.mark.parametrize("protocol", ["foxglove.websocket.v1", "foxglove.sdk.v1"])
def test_viewers_are_served_by_either_name_of_the_protocol(server, connect, gap, protocol):
    _, publisher = gap
    client = connect(server, protocol=protocol)
    assert client.wait("serverInfo")["name"] == "roadmend"
    subscribed(client)
    assert client.wait_while(lambda: publisher.publish(Float64(data=0.25)))["value"] == {"data": 0.25}
    client.ask(get=[])
    assert client.wait("parameters")["parameters"] == []


def test_a_topic_whose_publisher_comes_back_is_shown_to_who_asked_for_it_meanwhile(server, connect, gap):
    node, first = gap
    client = subscribed(connect(server))
    client.wait_while(lambda: first.publish(Float64(data=0.25)))
    client.ask(unsubscribe="/gap")
    while node.count_subscribers("/gap"):
        time.sleep(0.05)
    node.destroy_publisher(first)
    late = subscribed(connect(server))
    while not node.count_subscribers("/gap"):
        time.sleep(0.05)
    again = node.create_publisher(Float64, "/gap", 10)
    assert late.wait_while(lambda: again.publish(Float64(data=0.5)))["value"] == {"data": 0.5}


def test_bytes_that_are_too_few_for_a_message_are_not_shown_and_end_nothing(server, connect, gap):
    publisher = gap[0].create_publisher(Command, "/asked", 10)
    client = connect(server)
    client.wait("channel", lambda heard: heard["topic"] == "/asked")
    client.ask(subscribe="/asked")
    client.wait_while(lambda: publisher.publish(Command(throttle=0.25)))
    publisher.publish(b"\0\1\0\0")
    publisher.publish(Command(throttle=0.5))
    assert client.wait("message", lambda heard: heard["value"]["throttle"] != 0.25)["value"]["throttle"] == 0.5


def test_an_address_that_is_not_this_machines_is_one_line(domain):
    command = [sys.executable, "-m", "roadmend.nodes.foxglove", "--ros-args", "-p", "address:=192.0.2.1"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 2
    assert done.stderr.startswith("roadmend: 192.0.2.1:8765: cannot be listened on (")
    assert len(done.stderr.splitlines()) == 1
