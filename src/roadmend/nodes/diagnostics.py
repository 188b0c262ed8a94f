"""Every node's health on /diagnostics, once a second of wall time, and at once where it gets worse."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import IntEnum

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.clock import Clock, ClockType
from rclpy.node import Node

from roadmend.nodes import qos
from roadmend.recording import topics

PERIOD_S = 1.0


class Level(IntEnum):
    """Mirrors diagnostic_msgs/DiagnosticStatus."""

    OK = 0
    WARN = 1
    ERROR = 2
    STALE = 3


@dataclass(frozen=True, slots=True)
class Health:
    """How a node is doing."""

    level: Level
    message: str
    values: Mapping[str, object] = field(default_factory=dict)


class DiagnosticsReporter:
    """Publishes a node's health regularly and whenever asked."""

    def __init__(self, node: Node, collect: Callable[[], Health]) -> None:
        self._node = node
        self._collect = collect
        self._level = Level.OK  # as published last
        self._publisher = node.create_publisher(DiagnosticArray, topics.DIAGNOSTICS, qos.DIAGNOSTIC)
        # Steady time: health must be reported while simulation time stands still.
        self._timer = node.create_timer(PERIOD_S, self.publish, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def publish(self) -> None:
        """Publish the node's health now."""
        health = self._collect()
        self._level = health.level
        status = DiagnosticStatus(
            level=bytes([health.level]),
            name=self._node.get_fully_qualified_name(),
            message=health.message,
            hardware_id="roadmend",
            values=[KeyValue(key=key, value=str(value)) for key, value in health.values.items()],
        )
        message = DiagnosticArray(status=[status])
        message.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(message)

    def complain(self, level: Level) -> None:
        """Publish now if what has just become known is worse than what was said: a fault may be over in a second."""
        if level > self._level:
            self.publish()
            self._level = max(level, self._level)  # so that it is said once, whatever else there was to say
