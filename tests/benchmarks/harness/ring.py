"""A bare ring of rclpy nodes: the yardstick for the graph. As many hops and bytes, and nothing else."""

import statistics
import sys
import time
from array import array
from collections.abc import Sequence

from rclpy.node import Node
from std_msgs.msg import UInt8MultiArray

from roadmend.nodes import qos
from roadmend.nodes.parameters import declare
from roadmend.nodes.spinning import run_node


class RingNode(Node):
    """Passes each message on to the next node; the first of the ring also counts the rounds."""

    def __init__(self) -> None:
        super().__init__("ring_node")
        self.finished = False
        place = declare(self, "place", 0, "place in the ring", low=0, high=100)
        size = declare(self, "size", 3, "nodes in the ring", low=2, high=100)
        count = declare(self, "bytes", 1000, "bytes of the message that this node sends", low=0, high=10_000_000)
        self._rounds = declare(self, "rounds", 1000, "rounds to run", low=1, high=10_000_000)
        self._is_first = place == 0
        self._message = UInt8MultiArray(data=array("B", bytes(count)))
        self._done = 0
        self._marks: list[float] = []
        self._publisher = self.create_publisher(UInt8MultiArray, f"ring/hop_{place}", qos.STREAM)
        self.create_subscription(UInt8MultiArray, f"ring/hop_{(place - 1) % size}", self._pass_on, qos.STREAM)
        if self._is_first:
            self._timer = self.create_timer(0.25, self._kick)

    def _kick(self) -> None:
        """Send the first message until it has come round once."""
        if self._done == 0:
            self._publisher.publish(self._message)

    def _pass_on(self, _message: UInt8MultiArray) -> None:
        if self._is_first:
            if self._done == 0:
                self._timer.cancel()
            self._done += 1
            self._marks.append(time.perf_counter())
            if self._done > self._rounds:
                gaps = [after - before for before, after in zip(self._marks, self._marks[1:], strict=False)]
                print(f"{statistics.fmean(gaps):.9f}", flush=True)
                self.finished = True
                return
        self._publisher.publish(self._message)


def main(args: Sequence[str] | None = None) -> int:
    """Run one node of the ring."""
    return run_node(RingNode, args)


if __name__ == "__main__":
    sys.exit(main())
