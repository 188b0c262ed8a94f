"""A publisher that loads the recorder: numbered messages of one size, at a rate or as fast as they are taken."""

import contextlib
import json
import random
import struct
import sys
import time
from collections.abc import Sequence

from rclpy.duration import Duration
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import UInt8MultiArray

from roadmend.nodes.parameters import declare
from roadmend.nodes.spinning import run_node

TOPIC = "load"
BEGUN = "publishing"  # printed, a line for itself, when the first message goes out
MARK = struct.Struct("<QQ")  # number, and the wall time [ns] of publishing; begins each message's data
DATA = 16  # [bytes] of a serialized message before its data
_HEAD = struct.Struct("<4sIII")  # encapsulation, dimensions, offset, length of the data
_VARIETY = 64  # different contents, so that no compressor learns them
_PIECE_S = 0.02  # [s] of publishing between two looks at the executor
_MATCHED_S = 0.3  # [s] until the other side knows of the match as well


def serialized_messages(size: int, count: int = _VARIETY) -> list[bytes]:
    """Messages of ``size`` random bytes, which do not get smaller by compression, serialized."""
    draw = random.Random(7)
    return [_HEAD.pack(b"\x00\x01\x00\x00", 0, 0, size) + draw.randbytes(size) for _ in range(count)]


class LoadNode(Node):
    """Waits for a subscriber, says that it has begun, publishes, and prints how many messages went out."""

    def __init__(self) -> None:
        super().__init__("load_node")
        self.finished = False
        size = declare(self, "bytes", 20_000, "bytes of data in a message", low=MARK.size, high=10_000_000)
        self._count = declare(self, "count", 20_000, "messages to publish", low=1, high=1_000_000_000)
        self._rate = declare(self, "rate", 0.0, "messages a second; 0: as many as are taken", low=0.0, high=1e6)
        self._messages = serialized_messages(size)
        # Keeps all: publishing waits for the recorder where it is too fast, instead of overwriting.
        offer = QoSProfile(history=HistoryPolicy.KEEP_ALL, reliability=ReliabilityPolicy.RELIABLE)
        self._publisher = self.create_publisher(UInt8MultiArray, TOPIC, offer)
        self._sent = 0
        self._begun: float | None = None
        self.create_timer(0.001, self._publish)

    def _publish(self) -> None:
        if self.finished:
            return
        now = time.perf_counter()
        if self._begun is None:
            if self._publisher.get_subscription_count() == 0:
                return
            time.sleep(_MATCHED_S)
            print(BEGUN, flush=True)
            self._begun = now = time.perf_counter()
        until = now + _PIECE_S
        while now < until and self._sent < self._count:
            if self._rate and self._sent >= (now - self._begun) * self._rate:
                return
            self._send()
            now = time.perf_counter()
        if self._sent == self._count:
            seconds = now - self._begun
            self._publisher.wait_for_all_acked(Duration(seconds=30))
            print(json.dumps({"published": self._sent, "seconds": seconds}), flush=True)
            self.finished = True

    def _send(self) -> None:
        message = self._messages[self._sent % len(self._messages)]
        mark = MARK.pack(self._sent, time.time_ns())
        # The queue is full and stays so for longer than DDS waits: the recorder is behind, so try again.
        with contextlib.suppress(rclpy_implementation.RCLError):
            self._publisher.publish(b"".join((message[:DATA], mark, message[DATA + MARK.size :])))
            self._sent += 1


def main(args: Sequence[str] | None = None) -> int:
    """Run the node until everything is published."""
    return run_node(LoadNode, args)


if __name__ == "__main__":
    sys.exit(main())
