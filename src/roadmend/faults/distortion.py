"""What is done to the messages of a topic on their way: other values, other stamps, other frames, other times. No ROS."""

import math
import random
import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from roadmend.core.scene import COLUMNS
from roadmend.core.tick import INTERVAL_NS
from roadmend.recording import messages, topics
from roadmend.recording.codec import MessageType, encode

CLOCK = (
    "clock"  # stands for all that carries the tick: ego and objects for everybody, and the answers on their way back
)
FOREIGN_FRAME = "odom_of_another"
FAR_AHEAD_NS = 3600 * messages.NANOSECONDS
BACKWARDS_NS = -messages.NANOSECONDS
CROWD = 2000  # objects that are added where there shall be too many
_STAMP = struct.Struct("<iI")
_STAMP_AT = 4  # [bytes] of CDR's own header, little endian, as our publishers write it

Change = Callable[[Any], Any]  # of a message into another


def _with_ego(**changes: float) -> Change:
    def change(message: Any) -> Any:
        position = replace(message.pose.pose.position, **changes)
        pose = replace(message.pose, pose=replace(message.pose.pose, position=position))
        return replace(message, pose=pose)

    return change


def _with_fields(**changes: Any) -> Change:
    return lambda message: replace(message, **changes)


def _with_first(column: str, value: float) -> Change:
    """The first object spoilt; one that is, put into a list that has none."""

    def change(message: Any) -> Any:
        table = {name: np.array(getattr(message, name)) for name in COLUMNS}
        if not len(table["id"]):
            table = {name: np.ones(1, dtype=values.dtype) for name, values in table.items()}
        table[column][0] = value
        return replace(message, **table)

    return change


def _twice(message: Any) -> Any:
    """Each object two times."""
    table = {name: np.array(getattr(message, name)) for name in COLUMNS}
    table = {name: values if len(values) else np.ones(1, dtype=values.dtype) for name, values in table.items()}
    return replace(message, **{name: np.concatenate([values, values]) for name, values in table.items()})


def _crowded(message: Any) -> Any:
    """Beside those that are there, sound ones that stand far away: none of them may push out one that is near."""
    added: dict[str, Any] = {name: np.zeros(CROWD, dtype=getattr(message, name).dtype) for name in COLUMNS}
    added["id"] = np.arange(1_000_000, 1_000_000 + CROWD, dtype=added["id"].dtype)
    added["x"], added["y"] = added["x"] + 5000.0, 5000.0 + 10.0 * np.arange(CROWD, dtype=np.float64)
    added["length"], added["width"] = added["length"] + 4.5, added["width"] + 1.8
    return replace(message, **{name: np.concatenate([added[name], getattr(message, name)]) for name in COLUMNS})


def _shorter(column: str) -> Change:
    """One array shorter than the others, or longer where all are empty."""

    def change(message: Any) -> Any:
        values = np.array(getattr(message, column))
        return replace(message, **{column: values[:-1] if len(values) else np.ones(1, dtype=values.dtype)})

    return change


def _holed(message: Any) -> Any:
    x = np.array(message.x) if len(message.x) else np.ones(1)
    x[-1] = math.nan
    return replace(message, x=x)


_COMMANDS: Mapping[str, Change] = {
    "nan": _with_fields(throttle=math.nan),
    "infinite": _with_fields(throttle=math.inf, brake=0.0),
    "both_pedals": _with_fields(throttle=0.8, brake=0.3),
    "out_of_range": _with_fields(throttle=7.0, brake=0.0),
}
_CHANGES: Mapping[str, Mapping[str, Change]] = {
    topics.EGO: {"nan": _with_ego(x=math.nan), "infinite": _with_ego(y=math.inf)},
    topics.OBJECTS: {
        "nan": _with_first("x", math.nan),
        "infinite": _with_first("speed", math.inf),
        "negative_size": _with_first("length", -4.5),
        "duplicate_ids": _twice,
        "crowd": _crowded,
        "unequal": _shorter("yaw"),
    },
    topics.POLICY_COMMAND: _COMMANDS,
    topics.POLICY_TRAJECTORY: {"nan": _holed, "unequal": _shorter("speed"), "negative": _with_fields(interval=-0.1)},
    topics.REPAIR_COMMAND: _COMMANDS,
}
LINKS = (*_CHANGES, CLOCK)  # what a campaign can name
STRANGERS = ("stranger", "first_stranger")  # who comes when another speaks already, or before
_ANY = ("foreign_frame", "cut", "short", "backwards", "ahead", "silent", "late")
_TYPES: Mapping[str, MessageType] = {
    topics.EGO: messages.EGO,
    topics.OBJECTS: messages.OBJECTS,
    topics.POLICY_COMMAND: messages.COMMAND,
    topics.POLICY_TRAJECTORY: messages.TRAJECTORY,
    topics.REPAIR_COMMAND: messages.COMMAND,
}


def check_distortion(topic: str, name: str) -> None:
    """Look whether a topic's messages can be distorted so.

    Raises:
        ValueError: there is no such topic, or no such distortion of it.
    """
    if topic not in LINKS:
        raise ValueError(f"topic: {topic!r} is none of {', '.join(LINKS)}")
    known = ("jump",) if topic == CLOCK else (*_CHANGES[topic], *_ANY)
    known += STRANGERS if topic in (topics.POLICY_COMMAND, topics.REPAIR_COMMAND) else ()
    if name not in known:
        raise ValueError(f"distortion: {name!r} is none of those of {topic}: {', '.join(known)}")


def stamped(data: bytes, stamp: int) -> bytes:
    """A message with another stamp [ns]."""
    moved = bytearray(data)
    _STAMP.pack_into(moved, _STAMP_AT, stamp // messages.NANOSECONDS, stamp % messages.NANOSECONDS)
    return bytes(moved)


@dataclass(frozen=True, slots=True)
class Distortion:
    """What is done, to how many, when.

    Attributes:
        name: see ``check_distortion``.
        begin: number of the first tick whose messages may be touched.
        ticks: from there on.
        share: of them, 0 .. 1.
        late: ticks by which a message is held up.
        shift: of the clock [ns], from ``begin`` on and for good.
        seed: of which messages are touched.
    """

    name: str
    begin: int
    ticks: int = 20
    share: float = 1.0
    late: int = 0
    shift: int = 0
    seed: int = 0

    def touches(self, topic: str, tick: int) -> bool:
        """Whether the message of a topic at this tick, by its number, is touched; the same at every call."""
        if not self.begin <= tick < self.begin + self.ticks:
            return False
        return random.Random(f"{self.seed}/{topic}/{tick}").random() < self.share

    def first_in_a_row(self, topic: str, length: int) -> int | None:
        """Number of the first tick of the first ``length`` touched ones in a row; None if there never are so many."""
        row = 0
        for tick in range(self.begin, self.begin + self.ticks):
            row = row + 1 if self.touches(topic, tick) else 0
            if row == length:
                return tick - length + 1
        return None


class Distorter:
    """Takes in messages and gives what goes on of them.

    Attributes:
        first: stamp [ns], as who is behind sees it, of the first message that was touched; None before.
        touched: how many were.
    """

    def __init__(self, distortion: Distortion) -> None:
        self.first: int | None = None
        self.touched = 0
        self._what = distortion
        self._held: dict[str, list[tuple[int, bytes]]] = {}  # topic -> stamps and messages that are held up
        self._original: dict[int, int] = {}  # of a jumping clock: stamp behind it -> stamp before it

    def pass_on(self, topic: str, data: bytes) -> list[bytes]:
        """What goes on when this message of a topic has come: mostly the message itself."""
        stamp = messages.stamp_of_bytes(data)
        if self._what.name == "jump":
            return [self._jumped(topic, stamp, data)]
        released = self._released(topic, stamp)
        if not self._what.touches(topic, stamp // INTERVAL_NS):
            return [*released, data]
        self._note(stamp)
        if self._what.name == "silent":
            return released
        if self._what.name == "late":
            self._held.setdefault(topic, []).append((stamp, data))
            return released
        return [self._changed(topic, stamp, data)]

    def _changed(self, topic: str, stamp: int, data: bytes) -> bytes:
        name = self._what.name
        if name in ("backwards", "ahead"):
            return stamped(data, max(0, stamp + (BACKWARDS_NS if name == "backwards" else FAR_AHEAD_NS)))
        if name == "cut":
            return data[: len(data) // 2]
        if name == "short":
            return data[:_STAMP_AT]
        message = _TYPES[topic].decode(data)
        if name == "foreign_frame":
            return encode(replace(message, header=replace(message.header, frame_id=FOREIGN_FRAME)))
        return encode(_CHANGES[topic][name](message))

    def _released(self, topic: str, stamp: int) -> list[bytes]:
        """Messages that were held up long enough, now that a message with this stamp [ns] has come."""
        held = self._held.get(topic, [])
        due = [data for since, data in held if since <= stamp - self._what.late * INTERVAL_NS]
        self._held[topic] = held[len(due) :]
        return due

    def _jumped(self, topic: str, stamp: int, data: bytes) -> bytes:
        if topic == topics.REPAIR_COMMAND:  # on its way back to the simulator, which knows the true time
            return stamped(data, self._original.get(stamp, stamp))
        if stamp // INTERVAL_NS < self._what.begin:
            self._original[stamp] = stamp
            return data
        moved = max(0, stamp + self._what.shift)
        self._original[moved] = stamp
        self._note(moved)
        return stamped(data, moved)

    def _note(self, stamp: int) -> None:
        self.touched += 1
        if self.first is None:
            self.first = stamp
