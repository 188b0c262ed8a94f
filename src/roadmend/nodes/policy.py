"""policy_node: scenes in, commands and planned trajectories out."""

import sys
import time
from collections.abc import Sequence
from functools import partial

from nav_msgs.msg import Odometry
from rclpy.node import Node
from roadmend_msgs import msg

from roadmend.core.command import Decision
from roadmend.core.errors import RoadmendError
from roadmend.core.interfaces import Policy
from roadmend.core.route import Route
from roadmend.core.scene import Scene
from roadmend.nodes import qos
from roadmend.nodes.configuration import ConfigurationAnnouncer, Running
from roadmend.nodes.diagnostics import DiagnosticsReporter, Health, Level
from roadmend.nodes.fault import leave_fault
from roadmend.nodes.pairing import TickPairing
from roadmend.nodes.parameters import declare_name, declare_own, find_named
from roadmend.nodes.provenance import described
from roadmend.nodes.spinning import run_node
from roadmend.policies.registry import POLICY_REGISTRY, make_policy
from roadmend.recording import messages, topics
from roadmend.recording.codec import encode


class PolicyNode(Node):
    """Runs one driving policy, tick by tick."""

    def __init__(self) -> None:
        super().__init__("policy_node")
        self._given = declare_name(self, "policy", "modular", "driving policy to run", POLICY_REGISTRY)
        self._found = find_named("policy", self._given, POLICY_REGISTRY)
        kind, prefix = self._found.entry.parameters, self._found.label
        self._settings = {
            name: self.get_parameter(f"{prefix}.{name}").value for name in declare_own(self, prefix, kind)
        }
        self._configuration = ConfigurationAnnouncer(self, "policy", self._running)
        self._policy: Policy = make_policy(self._given, self._settings)
        self._route: Route | None = None
        self._pairing = TickPairing(topics.EGO, topics.OBJECTS)
        self._last_stamp = -1
        self._last: Decision | None = None
        self._failure = ""
        self._has_failed = False
        self._decided = 0
        self._command_publisher = self.create_publisher(msg.Command, topics.POLICY_COMMAND, qos.COMMAND)
        self._trajectory_publisher = self.create_publisher(msg.Trajectory, topics.POLICY_TRAJECTORY, qos.STREAM)
        self.create_subscription(msg.Route, topics.ROUTE, self._on_route, qos.LATCHED, raw=True)
        for kind, topic in ((Odometry, topics.EGO), (msg.ObjectList, topics.OBJECTS)):
            self.create_subscription(kind, topic, partial(self._on_part, topic), qos.STREAM, raw=True)
        self._diagnostics = DiagnosticsReporter(self, self._health)
        self._configuration.announce()

    def _running(self) -> Running:
        return Running(self._given, described(self._found, self._policy, self._settings))

    def _on_route(self, data: bytes) -> None:
        self._last_stamp = -1
        self._last = None
        try:
            self._route = messages.route_of(messages.ROUTE.decode(data))
            self._policy.reset(self._route)
        except Exception as error:  # noqa: BLE001 - a policy that fails must be seen, not end the node
            self._route = None
            self._note(error)
            self.get_logger().error(f"no route to drive: {self._failure}")
        else:
            self._failure = ""

    def _on_part(self, topic: str, data: bytes) -> None:
        try:
            stamp = messages.stamp_of_bytes(data)
        except ValueError as error:  # as good as none: the tick is not decided
            self.get_logger().error(f"unusable: {topic}: {error}", throttle_duration_sec=1.0)
            return
        tick = self._pairing.add(stamp, topic, data, time.monotonic())
        if tick is not None:
            self._decide(stamp, tick[topics.EGO], tick[topics.OBJECTS])

    def _decide(self, stamp: int, ego: bytes, objects: bytes) -> None:
        if self._route is None:
            return  # the simulator repeats the first tick until it is answered
        if stamp != self._last_stamp:
            try:
                if stamp < self._last_stamp:
                    self._policy.reset(self._route)
                seen, signals = messages.objects_of(messages.OBJECTS.decode(objects))
                state = messages.ego_of(messages.EGO.decode(ego), self._route.ego_length, self._route.ego_width)
                self._last = self._policy.step(Scene(stamp * 1e-9, state, seen, signals))
            except Exception as error:  # noqa: BLE001 - a policy that fails must be seen, not end the node
                self._note(error)
                self.get_logger().error(
                    f"no decision at {stamp * 1e-9:.2f} s: {self._failure}", throttle_duration_sec=1.0
                )
                return
            self._failure = ""
            self._last_stamp = stamp
            self._decided += 1
        if self._last is not None:
            # A repeated tick gets the same answer again.
            header = messages.header_at(stamp)
            self._trajectory_publisher.publish(encode(messages.trajectory_message_of(self._last.trajectory, header)))
            self._command_publisher.publish(encode(messages.command_message_of(self._last.command, header)))

    def _note(self, error: Exception) -> None:
        """Keep what went wrong, and leave it for the launcher the first time: it ends the run with it."""
        self._failure = str(error) if isinstance(error, RoadmendError) else f"{type(error).__name__}: {error}"
        if not self._has_failed:
            self._has_failed = True
            leave_fault(error)

    def _health(self) -> Health:
        values = {"policy": self._policy.name, "decisions": self._decided}
        if self._failure:
            return Health(Level.ERROR, f"the policy failed: {self._failure}", values)
        if self._route is None:
            return Health(Level.WARN, "waiting for a route", values)
        return Health(Level.OK, "driving" if self._decided else "waiting for objects and odometry", values)


def main(args: Sequence[str] | None = None) -> int:
    """Run the node until it is stopped."""
    return run_node(PolicyNode, args)


if __name__ == "__main__":
    sys.exit(main())
