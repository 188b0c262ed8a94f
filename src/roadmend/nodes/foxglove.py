"""Shows the running graph in Foxglove, live: every topic, and the parameters of the nodes that can be changed."""

import sys
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from pydantic import Field
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile

from roadmend.core.errors import InputError
from roadmend.core.parameters import Parameters
from roadmend.nodes.configuration import ConfigurationAnnouncer
from roadmend.nodes.diagnostics import DiagnosticsReporter, Health, Level
from roadmend.nodes.discovery import LookUp, request_for
from roadmend.nodes.needed import needed
from roadmend.nodes.origin_gate import OriginGate, hidden_address
from roadmend.nodes.parameters import declare_parameters
from roadmend.nodes.spinning import run_node
from roadmend.recording import topics
from roadmend.recording.timekeeper import Timekeeper

with needed():
    import foxglove
    from foxglove.websocket import Capability, ChannelView, Client, ServerListener, WebSocketServer

    from roadmend.nodes.foxglove_parameters import ParameterBridge

TEND_PERIOD_S = 0.05  # [s] of wall time between two looks at what clients want and at the clock
DISCOVERY_PERIOD_S = 0.2  # [s] between two looks at the graph
DEPTH = 100  # messages of a topic that may wait for this node


class FoxgloveParameters(Parameters):
    """Parameters of the node, read once at start."""

    address: str = Field(
        "127.0.0.1", description="where to listen; elsewhere than on loopback, others may look and change parameters"
    )
    port: int = Field(8765, ge=0, le=65535, description="where to listen; 0 takes a free one")
    allowed_origins: tuple[str, ...] = Field(
        ("https://app.foxglove.dev",), description="web pages that may connect; programs always may"
    )
    nodes: tuple[str, ...] = Field(("repair_node", "viz_node"), description="nodes whose parameters are shown")


@dataclass(slots=True)
class _Bridged:
    """A topic that clients can subscribe to; the graph is asked for it only while one does."""

    channel: foxglove.Channel
    message_type: Any
    callback: Callable[[bytes], None]
    clients: int = 0
    request: QoSProfile | None = None
    subscription: Any = None


class FoxgloveNode(Node):
    """Serves Foxglove's WebSocket protocol; messages pass through as the bytes that came over the wire."""

    def __init__(self) -> None:
        super().__init__("foxglove_node")
        settings = declare_parameters(self, FoxgloveParameters)
        self._configuration = ConfigurationAnnouncer(self, "foxglove")
        self._timekeeper = Timekeeper()
        self._bridged: dict[str, _Bridged] = {}
        self._look_up = LookUp(lambda error: self.get_logger().error(f"not shown: {error}"))
        self._wishes: deque[tuple[str, int]] = deque()  # topics, and clients come (+1) or gone (-1)
        self._told_ns = -1  # [ns] time that clients know of
        self._refusals: dict[str, str] = {}  # parameter and why its last value was refused
        self._sdk_context = foxglove.Context()
        parameters = ParameterBridge(self, settings.nodes, self._on_tried, self._on_changed)
        inner = hidden_address()
        self._server: WebSocketServer = foxglove.start_server(
            name="roadmend",
            host=inner,
            port=0,
            capabilities=[Capability.Parameters, Capability.Time],
            server_listener=_Listener(parameters, self._wishes),
            context=self._sdk_context,
        )
        try:
            self._gate = OriginGate(
                settings.address, settings.port, (inner, self._server.port), settings.allowed_origins
            )
        except InputError:
            self._server.stop()
            raise
        self._url = f"ws://{settings.address}:{self._gate.port}"
        wall = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(DISCOVERY_PERIOD_S, self._discover, clock=wall)
        self._configuration.announce()
        self.create_timer(TEND_PERIOD_S, self._tend, clock=wall)
        self._diagnostics = DiagnosticsReporter(self, self._health)
        self._discover()
        self.get_logger().info(f"open {self._url} in Foxglove")

    def close(self) -> None:
        """Let the clients go."""
        self._gate.close()
        self._server.stop()

    def _discover(self) -> None:
        for name, types in self.get_topic_names_and_types():
            bridged = self._bridged.get(name)
            if bridged is not None:
                # One that comes, comes back or takes another's place may offer less than what is asked for, and nothing
                # of it would arrive.
                if bridged.subscription is not None and self.count_publishers(name):
                    self._subscribe(name, bridged)
            elif self._look_up.is_due(name, types) and "/_" not in name and self.count_publishers(name):
                self._begin(name, types)

    def _begin(self, name: str, types: list[str]) -> None:
        found = self._look_up.find(name, types)
        if found is None:
            return
        definition, message_type = found
        schema = foxglove.Schema(name=definition.type_name, encoding="ros2msg", data=definition.text.encode())
        # The SDK tells its clients of a channel and only then takes note that they may subscribe to it: who is quick is
        # refused, and no viewer asks twice.
        with self._gate.held_back():
            channel = foxglove.Channel(name, message_encoding="cdr", schema=schema, context=self._sdk_context)
        time_of = self._timekeeper.rule_for(definition)
        is_clock = name == topics.CLOCK

        def pass_on(data: bytes) -> None:
            before = self._timekeeper.now_ns
            try:
                time_ns = time_of(data)
            except ValueError:  # too few bytes to hold a stamp, and for anybody to read
                return
            if is_clock and time_ns < before:
                self._server.clear_session()  # a new episode, or a replay from the start: what was drawn is history
            channel.log(data, log_time=time_ns)

        self._bridged[name] = bridged = _Bridged(channel, message_type, pass_on)
        if is_clock:  # which is followed even where nobody looks at it
            bridged.clients += 1
            self._subscribe(name, bridged)

    def _subscribe(self, name: str, bridged: _Bridged, *, anew: bool = False) -> None:
        offers = [info.qos_profile for info in self.get_publishers_info_by_topic(name)]
        request = request_for(offers, DEPTH)
        if bridged.subscription is not None:
            if bridged.request == request and not anew:
                return
            self.destroy_subscription(bridged.subscription)
        bridged.request = request
        bridged.subscription = self.create_subscription(bridged.message_type, name, bridged.callback, request, raw=True)

    def _tend(self) -> None:
        """Do what the server's threads have asked for, and tell the clients the time."""
        while self._wishes:
            name, change = self._wishes.popleft()
            bridged = self._bridged[name]
            bridged.clients += change
            if change > 0:
                # A latched topic is subscribed to anew for each client: DDS then delivers again what is latched.
                latched = bridged.request is not None and bridged.request.durability == DurabilityPolicy.TRANSIENT_LOCAL
                self._subscribe(name, bridged, anew=latched)
            elif bridged.clients == 0:
                self.destroy_subscription(bridged.subscription)
                bridged.subscription = None
        if self._timekeeper.now_ns != self._told_ns:
            self._told_ns = self._timekeeper.now_ns
            self._server.broadcast_time(self._told_ns)

    def _on_tried(self, name: str, reason: str) -> None:
        if reason:
            self._refusals[name] = reason
            self.get_logger().warning(f"{name}: {reason}")
            self._server.publish_status(f"{name}: {reason}", foxglove.StatusLevel.Warning, name)
        elif self._refusals.pop(name, None) is not None:
            self._server.remove_status([name])

    def _on_changed(self, parameters: list[foxglove.Parameter]) -> None:
        self._server.publish_parameter_values(parameters)

    def _health(self) -> Health:
        values = {
            "address": self._url,
            "topics": len(self._bridged),
            "topics passed on": sum(bridged.subscription is not None for bridged in self._bridged.values()),
            "connections refused by their origin": self._gate.refused,
        }
        values |= {f"not shown: {name}": why for name, why in self._look_up.refused.items()}
        refusals = {f"refused: {name}": why for name, why in dict(self._refusals).items()}
        if refusals:
            return Health(Level.WARN, "a parameter's new value was refused", values | refusals)
        if self._look_up.refused:
            return Health(Level.WARN, f"{len(self._look_up.refused)} topics not shown", values)
        return Health(Level.OK, "serving", values)


class _Listener(ServerListener):
    """Called from the server's threads: answers for parameters, and leaves to the node who wants which topic."""

    def __init__(self, parameters: ParameterBridge, wishes: deque[tuple[str, int]]) -> None:
        self._parameters = parameters
        self._wishes = wishes

    def on_subscribe(self, client: Client, channel: ChannelView) -> None:  # noqa: ARG002 -- the SDK names them
        """A client wants to see a topic."""
        self._wishes.append((channel.topic, 1))

    def on_unsubscribe(self, client: Client, channel: ChannelView) -> None:  # noqa: ARG002
        """A client has seen enough of a topic, or has gone."""
        self._wishes.append((channel.topic, -1))

    def on_get_parameters(
        self,
        client: Client,  # noqa: ARG002
        param_names: list[str],
        request_id: str | None = None,  # noqa: ARG002
    ) -> list[foxglove.Parameter]:
        """A client wants to know some parameters, or all."""
        return self._parameters.get(param_names)

    def on_set_parameters(
        self,
        client: Client,  # noqa: ARG002
        parameters: list[foxglove.Parameter],
        request_id: str | None = None,  # noqa: ARG002
    ) -> list[foxglove.Parameter]:
        """A client wants to change parameters."""
        return self._parameters.set(parameters)


def main(args: Sequence[str] | None = None) -> int:
    """Run the node until it is told to stop."""
    return run_node(FoxgloveNode, args)


if __name__ == "__main__":
    sys.exit(main())
