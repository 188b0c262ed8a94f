"""relay_node: passes messages on, distorted for a while; or a stranger, who speaks where somebody else does.

For campaigns of faults (``roadmend faults``). Between two nodes it comes by remapping: the one publishes, or listens, under
another name, and the relay listens to the one name and publishes under the other.
"""

import json
import signal
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

from nav_msgs.msg import Odometry
from pydantic import Field
from rclpy.node import Node
from roadmend_msgs import msg

from roadmend.core.command import Command
from roadmend.core.errors import InputError
from roadmend.core.parameters import Parameters
from roadmend.core.tick import INTERVAL_NS
from roadmend.core.whole_file import write_text
from roadmend.faults.distortion import STRANGERS, Distorter, Distortion
from roadmend.nodes import qos
from roadmend.nodes.configuration import ConfigurationAnnouncer
from roadmend.nodes.diagnostics import DiagnosticsReporter, Health, Level
from roadmend.nodes.parameters import declare_parameters
from roadmend.nodes.parent_death import at_parent_death
from roadmend.nodes.spinning import run_node
from roadmend.recording import messages, topics
from roadmend.recording.codec import encode

_KINDS: dict[str, tuple[type, Any]] = {
    topics.EGO: (Odometry, qos.STREAM),
    topics.OBJECTS: (msg.ObjectList, qos.STREAM),
    topics.POLICY_COMMAND: (msg.Command, qos.COMMAND),
    topics.POLICY_TRAJECTORY: (msg.Trajectory, qos.STREAM),
    topics.REPAIR_COMMAND: (msg.Command, qos.COMMAND),
}
_ASKS = Command(1.0, 0.0)  # what a stranger wants: full throttle


class RelayParameters(Parameters):
    """Parameters of the node, read once at start."""

    links: tuple[str, ...] = Field((), description="what is passed on, as TOPIC>FROM>TO; TOPIC alone of a stranger")
    distortion: str = Field(
        "nan",
        description="what is done to messages; stranger: nothing, but full throttle is asked for on the first topic, by a "
        "publisher that comes when it begins; first_stranger: by one that is there from the start",
    )
    begin: int = Field(0, ge=0, le=1_000_000, description="number of the first tick with it")
    ticks: int = Field(20, ge=1, le=100_000, description="how many of them")
    share: float = Field(1.0, ge=0.0, le=1.0, description="of the messages while it lasts")
    late: int = Field(0, ge=0, le=1000, description="ticks by which messages are held up")
    shift: float = Field(0.0, ge=-60.0, le=60.0, description="[s] by which the clock jumps")
    seed: int = Field(0, ge=0, le=2**31 - 1, description="of which messages are touched")
    report: str = Field("", description="file for what was touched, written when it begins; none if empty")
    with_parent: bool = Field(False, description="end with the process that started the node")


class RelayNode(Node):
    """Between nodes, or beside one."""

    def __init__(self) -> None:
        super().__init__("relay_node")
        self._settings = settings = declare_parameters(self, RelayParameters)
        if settings.with_parent:
            at_parent_death(signal.SIGTERM)
        shift = round(settings.shift * messages.NANOSECONDS)
        self._distorter = Distorter(
            Distortion(
                settings.distortion,
                settings.begin,
                settings.ticks,
                settings.share,
                settings.late,
                shift,
                settings.seed,
            )
        )
        self._is_told = False
        configuration = ConfigurationAnnouncer(self, self.get_name().removesuffix("_node"))
        if not settings.links or any(link.partition(">")[0] not in _KINDS for link in settings.links):
            raise InputError("parameter links", f"{settings.links} names no topic", f"choose of {', '.join(_KINDS)}")
        if settings.distortion in STRANGERS:
            self._intrude(settings.links[0])
        else:
            for link in settings.links:
                self._connect(*link.split(">"))
        self._diagnostics = DiagnosticsReporter(self, self._health)
        configuration.announce()

    def _health(self) -> Health:
        if not self._is_told:
            return Health(Level.OK, "passes on what it gets", {"touched": 0})
        what = f"disturbs on purpose: {self._settings.distortion}"
        return Health(Level.WARN, what, {"touched": self._distorter.touched})

    def _connect(self, topic: str, source: str, target: str) -> None:
        kind, profile = _KINDS[topic]
        publisher = self.create_publisher(kind, target, profile)
        self.create_subscription(kind, source, partial(self._on_message, topic, publisher), profile, raw=True)

    def _on_message(self, topic: str, publisher: Any, data: bytes) -> None:
        for each in self._distorter.pass_on(topic, data):
            publisher.publish(each)
        if not self._is_told and self._distorter.first is not None:
            self._tell(self._distorter.first)

    def _intrude(self, topic: str) -> None:
        kind, profile = _KINDS[topic]
        self._open = partial(self.create_publisher, kind, topic, profile)
        self._publisher = self._open() if self._settings.distortion == "first_stranger" else None
        self.create_subscription(Odometry, topics.EGO, self._on_tick, qos.STREAM, raw=True)

    def _on_tick(self, data: bytes) -> None:
        stamp = messages.stamp_of_bytes(data)
        if 0 <= stamp // INTERVAL_NS - self._settings.begin < self._settings.ticks:
            self._publisher = self._publisher or self._open()
            self._publisher.publish(encode(messages.command_message_of(_ASKS, messages.header_at(stamp))))
            self._tell(stamp)

    def _tell(self, stamp: int) -> None:
        """Leave the first stamp [ns] that was touched, for who started this."""
        if self._is_told:
            return
        self._is_told = True
        if self._settings.report:
            write_text(Path(self._settings.report), json.dumps({"first": stamp}))


def main(args: Sequence[str] | None = None) -> int:
    """Run the node until it is stopped."""
    return run_node(RelayNode, args)


if __name__ == "__main__":
    sys.exit(main())
