"""Messages and bags made without ROS, and a ROS domain of its own for each test that starts nodes."""

import itertools
import math

import numpy as np
import pytest
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from roadmend.recording import definitions
from roadmend.recording.qos import Qos
from roadmend.recording.writer import BagOptions, BagWriter

SECOND = 10**9
LATCHED = Qos(depth=1, durability="transient_local", deadline_ns=SECOND // 2)
# Every kind of field that our graph sends: own types, nested arrays, plain ones, headers in the first place and not.
CORPUS = {
    "/clock": "rosgraph_msgs/msg/Clock",
    "/ego": "nav_msgs/msg/Odometry",
    "/objects": "roadmend_msgs/msg/ObjectList",
    "/policy/command": "roadmend_msgs/msg/Command",
    "/policy/trajectory": "roadmend_msgs/msg/Trajectory",
    "/repair/state": "roadmend_msgs/msg/RepairState",
    "/route": "roadmend_msgs/msg/Route",
    "/events": "roadmend_msgs/msg/ScenarioEvent",
    "/tf": "tf2_msgs/msg/TFMessage",
    "/markers": "visualization_msgs/msg/MarkerArray",
    "/diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
    "/text": "std_msgs/msg/String",
}


@pytest.fixture
def domain(domain, monkeypatch, tmp_path):
    """A ROS domain of its own; children inherit it, and leave their logs with the test."""
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path / "log"))
    return domain


class Maker:
    """Makes messages with arbitrary content by their installed definitions."""

    def __init__(self, seed=1):
        self.store = get_typestore(Stores.EMPTY)
        self.random = np.random.default_rng(seed)

    def __call__(self, type_name, **chosen):
        """A message with the chosen fields, all others arbitrary."""
        if type_name not in self.store.fielddefs:
            types = get_types_from_msg(definitions.find(type_name).text, type_name)
            self.store.register({name: types[name] for name in types if name not in self.store.fielddefs})
        _, fields = self.store.fielddefs[type_name]
        values = {name: chosen[name] if name in chosen else self._value(*kind) for name, kind in fields}
        return self.store.types[type_name](**values)

    def text(self, content):
        return self.cdr(self("std_msgs/msg/String", data=content))

    def stamped(self, type_name, time_ns, **chosen):
        """A message whose first field is a header, or a clock, with that time."""
        stamp = self("builtin_interfaces/msg/Time", sec=time_ns // SECOND, nanosec=time_ns % SECOND)
        if type_name == "rosgraph_msgs/msg/Clock":
            return self(type_name, clock=stamp)
        return self(type_name, header=self("std_msgs/msg/Header", stamp=stamp, frame_id="map"), **chosen)

    def cdr(self, message):
        return bytes(self.store.serialize_cdr(message, message.__msgtype__))

    def _value(self, node, detail):
        if node == Nodetype.NAME:
            return self(detail)
        if node == Nodetype.BASE:
            return self._primitive(detail[0])
        element, size = detail
        count = size if node == Nodetype.ARRAY else int(self.random.integers(0, 6))
        values = [self._value(*element) for _ in range(count)]
        if element[0] == Nodetype.NAME or element[1][0] == "string":
            return values
        return np.array(values, dtype={"byte": np.uint8, "char": np.uint8}.get(element[1][0], element[1][0]))

    def _primitive(self, kind):
        if kind == "bool":
            return bool(self.random.integers(2))
        if kind == "string":
            return str(self.random.choice(["", "a", "Straße 5", "one line, for people", "\u2713" * 40]))
        if kind.startswith("float"):
            number = float(np.dtype(kind).type(self.random.normal() * 10.0 ** self.random.integers(-3, 6)))
            return float(self.random.choice([number, math.nan, math.inf], p=[0.9, 0.05, 0.05]))
        if kind == "byte":
            return int(self.random.integers(128))  # rosbags takes a byte for signed, others do not
        limits = np.iinfo({"char": "uint8"}.get(kind, kind))
        return int(self.random.integers(limits.min, limits.max, dtype=limits.dtype, endpoint=True))


@pytest.fixture
def make():
    return Maker()


@pytest.fixture
def corpus(tmp_path, make):
    """A closed bag with 30 messages on each topic of the corpus, and the list of (topic, time, bytes)."""
    written = []
    with BagWriter(tmp_path / "corpus") as writer:
        for topic, type_name in CORPUS.items():
            writer.add_topic(topic, type_name, [Qos(), LATCHED] if topic == "/events" else [LATCHED])
        writer.add_topic("/silent", "std_msgs/msg/String", [Qos()])
        writer.add_metadata("roadmend", {"seed": "7", "outcome": "UNFINISHED"})
        writer.add_attachment("scenario.yaml", "application/yaml", "name: merge ✓\n".encode())
        for tick, (topic, type_name) in itertools.product(range(30), CORPUS.items()):
            time_ns = 5 * SECOND + tick * SECOND // 20
            written.append((topic, time_ns, make.cdr(make(type_name))))
            writer.write(*written[-1])
            if tick == 14:
                writer.flush()  # so that there are several chunks
        writer.add_metadata("roadmend", {"outcome": "GOAL"})
    return tmp_path / "corpus", written


@pytest.fixture
def split_corpus(tmp_path, make):
    """A bag of three files, and what was written."""
    written = []
    with BagWriter(tmp_path / "split", BagOptions(max_bagfile_duration=0.5)) as writer:
        for topic, type_name in CORPUS.items():
            writer.add_topic(topic, type_name, [LATCHED if topic == "/route" else Qos()])
        for tick, (topic, type_name) in itertools.product(range(30), CORPUS.items()):
            if topic != "/route" or not tick:
                written.append((topic, tick * SECOND // 20, make.cdr(make(type_name))))
                writer.write(*written[-1])
    return tmp_path / "split", written


def plain(value):
    """A decoded message as JSON could hold it, whoever decoded it."""
    if hasattr(value, "__msgtype__"):
        names = [name for name in vars(value) if name.islower() and name != "__msgtype__"]  # no constants
        return {name: plain(getattr(value, name)) for name in names}
    if isinstance(value, np.ndarray | list | tuple):
        return [plain(one) for one in value]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and not math.isfinite(value):
        return {"nan": "NaN", "inf": "Infinity", "-inf": "-Infinity"}[str(value)]
    return value


@pytest.fixture(name="plain")
def plain_fixture():
    return plain
