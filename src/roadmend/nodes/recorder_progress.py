"""How far the recorder has come, told to whoever could run away from it.

In lockstep the graph runs as fast as the machine lets it, and a recorder that the machine lets wait for a moment loses what
does not fit into DDS's queues: 512 messages in Fast DDS's shared memory, the last 50 of a publisher when it notices a gap,
which is up to 3 s later where Fast DDS is not told otherwise. So the recorder tells the newest time of the clock that it has written, and the simulator stays
within ``LEAD_TICKS`` of it. The topic is hidden, as ROS calls a name with a leading underscore: tools do not list it, bags do
not hold it.
"""

from collections.abc import Callable

from builtin_interfaces.msg import Time
from rclpy.node import Node

from roadmend.core.tick import INTERVAL_NS
from roadmend.nodes import qos
from roadmend.recording import topics

LEAD_TICKS = 20  # by which the simulator may be ahead: eight messages each, a third of what the queues hold
REPORT_TICKS = 5  # after so many a report is due

_NS = 1_000_000_000


class ProgressReport:
    """Tells the newest time that is in the bag."""

    def __init__(self, node: Node) -> None:
        self._publisher = node.create_publisher(Time, topics.RECORDER_PROGRESS, qos.DIAGNOSTIC)
        self._told_ns = -1

    def see(self, now_ns: int) -> None:
        """Tell it if the clock [ns] has gone on for long enough, or back."""
        if self._told_ns < 0 or not 0 <= now_ns - self._told_ns < REPORT_TICKS * INTERVAL_NS:
            self.tell(now_ns)

    def tell(self, now_ns: int) -> None:
        """Tell it now if it is news: whoever waits does not wait for ticks that do not come."""
        if now_ns != self._told_ns:
            self._told_ns = now_ns
            self._publisher.publish(Time(sec=now_ns // _NS, nanosec=now_ns % _NS))


class ProgressWatch:
    """Knows how far a recorder has come, and who must wait for it. Where none has ever told, nobody is waited for."""

    def __init__(self, node: Node, patience: float, on_report: Callable[[], None]) -> None:
        """Listen.

        Args:
            node: on whose behalf.
            patience: [s] of wall time for which one tick waits at most.
            on_report: called at each report.
        """
        self._newest_ns: int | None = None
        self._patience, self._on_report, self._get_logger = patience, on_report, node.get_logger
        node.create_subscription(Time, topics.RECORDER_PROGRESS, self._hear, qos.DIAGNOSTIC)

    def _hear(self, message: Time) -> None:
        self._newest_ns = message.sec * _NS + message.nanosec
        self._on_report()

    def holds(self, now_ns: int, waited: float) -> bool:
        """Whether the next tick must wait; where patience ends that is said, and nobody waits until the recorder tells again.

        Args:
            now_ns: time of the present tick [ns].
            waited: since it was published [s] of wall time.
        """
        if self._newest_ns is None or now_ns - self._newest_ns < LEAD_TICKS * INTERVAL_NS:
            return False
        if waited <= self._patience:
            return True
        self._get_logger().warning(f"the recorder has written nothing for {self._patience:g} s: it goes on without it")
        self._newest_ns = None
        return False
