"""How far the recorder has come, told to whoever could run away from it.

In lockstep the graph runs as fast as the machine lets it, and a recorder that the machine lets wait for a moment loses what
does not fit into DDS's queues: 512 messages in Fast DDS's shared memory, the last 50 of a publisher when it notices a gap,
which is up to 3 s later. So the recorder tells the newest time of the clock that it has written, and the simulator stays
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
    """Knows how far a recorder has come. Where none has ever told, nobody is waited for."""

    def __init__(self, node: Node, on_report: Callable[[], None]) -> None:
        """Listen.

        Args:
            node: on whose behalf.
            on_report: called at each report.
        """
        self._newest_ns: int | None = None
        self._on_report = on_report
        node.create_subscription(Time, topics.RECORDER_PROGRESS, self._hear, qos.DIAGNOSTIC)

    def _hear(self, message: Time) -> None:
        self._newest_ns = message.sec * _NS + message.nanosec
        self._on_report()

    def is_behind(self, now_ns: int) -> bool:
        """Whether a tick at this time [ns] is further ahead of the recorder than the next one may be."""
        return self._newest_ns is not None and now_ns - self._newest_ns >= LEAD_TICKS * INTERVAL_NS

    def forget(self) -> None:
        """Wait no more, until the recorder tells again."""
        self._newest_ns = None
