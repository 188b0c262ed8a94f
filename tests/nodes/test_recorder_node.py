"""recorder_node in this process, with publishers in the test's hands; as a process: tests/recording/test_recorder.py."""

import json
import time

import pytest
import rclpy
from rclpy.experimental import EventsExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import serialize_message
from roadmend_msgs.msg import Command, ScenarioEvent
from std_msgs.msg import Header, String

from roadmend.nodes import qos
from roadmend.nodes.recorder import RecorderNode
from roadmend.recording import topics
from roadmend.recording.errors import RecordingError
from roadmend.recording.reader import BagReader

LIMIT_S = 60.0  # [s] for anything to happen
MORE = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL)
LESS = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT, durability=DurabilityPolicy.VOLATILE)


class Recorder:
    """Writes ``bag``; its summary lies beside it."""

    def __init__(self, folder):
        self.bag, self.summary = folder / "bag", folder / "recorder.json"
        values = {"output": folder, "name": "bag", "drain_limit": 0.3, "summary": self.summary}
        words = [word for name, value in values.items() for word in ("-p", f"{name}:={value}")]
        rclpy.init(args=["test", "--ros-args", *words])
        self.node = RecorderNode()
        self.executor = EventsExecutor()
        self.executor.add_node(self.node)
        self.written = []  # messages, as bytes
        self.is_disk_full = False
        self._write, self.node._writer.write = self.node._writer.write, self._on_write

    def _on_write(self, name, time_ns, data):
        if self.is_disk_full:
            raise RecordingError(self.bag, "no space left")
        self._write(name, time_ns, data)
        self.written.append(bytes(data))

    def until(self, done):
        limit = time.monotonic() + LIMIT_S
        while not done():
            assert time.monotonic() < limit, "it did not happen"
            self.executor.spin_once(timeout_sec=0.02)

    def until_written(self, publisher, message, mark):
        """Say it until something with the mark has been written: how long DDS takes to bring two together is not known."""

        def is_written():
            publisher.publish(message)
            return any(mark in data for data in self.written)

        self.until(is_written)

    def look(self):
        """Let the node look at the graph as it is now."""
        self.node._discover()

    @property
    def told(self):
        return json.loads(self.summary.read_text(encoding="utf-8"))


@pytest.fixture
def recorder(domain, tmp_path, monkeypatch):
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path))
    there = Recorder(tmp_path)
    yield there
    there.executor.remove_node(there.node)
    there.node.destroy_node()
    there.executor.shutdown()
    rclpy.try_shutdown()


@pytest.mark.parametrize("is_seen_to_leave", [True, False])
def test_a_publisher_that_comes_back_and_offers_less_is_recorded_too(recorder, node, is_seen_to_leave):
    driver = node("driver")
    first = driver.create_publisher(String, "said", MORE)
    recorder.until_written(first, String(data="before"), b"before")
    driver.destroy_publisher(first)
    if is_seen_to_leave:
        recorder.until(lambda: not recorder.node.count_publishers("/said"))
        recorder.look()
    second = driver.create_publisher(String, "said", LESS)
    recorder.until_written(second, String(data="after"), b"after")
    recorder.node.close()
    said = [message.value.data for message in BagReader(recorder.bag).messages(["/said"])]
    assert {*said} == {"before", "after"}


@pytest.mark.parametrize(("topic", "kind"), [(topics.POLICY_COMMAND, Command), (topics.EVENTS, ScenarioEvent)])
@pytest.mark.parametrize("size", [4, 24])
def test_bytes_that_are_no_message_are_recorded_and_end_nothing(recorder, node, topic, kind, size):
    publisher = node("driver").create_publisher(kind, topic, qos.EVENT)
    mark = f"frame {size}"
    whole = serialize_message(kind(header=Header(frame_id=mark)))
    recorder.until_written(publisher, whole, mark.encode())
    recorder.written.clear()
    cut = whole[:size]
    recorder.until(lambda: publisher.publish(cut) or cut in recorder.written)
    recorder.node.close()
    sizes = {len(record.data) for record in BagReader(recorder.bag).records([f"/{topic}"])}
    assert size in sizes
    assert max(sizes) > size


def test_what_was_dropped_since_the_disk_was_full_is_in_the_summary(recorder, node):
    publisher = node("driver").create_publisher(String, "said", MORE)
    recorder.until_written(publisher, String(data="before"), b"before")
    recorder.is_disk_full = True
    recorder.until(lambda: publisher.publish(String(data="after")) or recorder.node._dropped > 2)
    with pytest.raises(RecordingError, match="no space left"):
        recorder.node.close()
    assert recorder.told["dropped"] > 2
    assert recorder.told["messages"] > 0
