"""Each node's effective configuration on one latched topic: announced by itself, and refused where a name is unknown."""

import json
import os
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile

from roadmend import __version__
from roadmend.nodes import qos
from roadmend.nodes.announcement import PARAMETER, Announcement, account
from roadmend.nodes.inputs import COMMAND, REPAIRED, Input
from roadmend.nodes.ros_arguments import IGNORED, SHARED, unknown_parameter
from roadmend.recording import topics

_LISTEN = QoSProfile(depth=200, durability=qos.LATCHED.durability, reliability=qos.LATCHED.reliability)


@dataclass(frozen=True, slots=True)
class Running:
    """What a node runs."""

    label: str  # what it is called, as it was asked for
    values: Mapping[str, str] = field(default_factory=dict)  # see Announcement


class ConfigurationAnnouncer:
    """Announces what a node is, once it is made and whenever that changes. Make it when all parameters are declared."""

    def __init__(
        self,
        node: Node,
        role: str,
        collect: Callable[[], Running] | None = None,
        is_told: Callable[[str], bool] = lambda _name: True,
    ) -> None:
        """Look at the parameters that were given; ``announce`` says the rest.

        Args:
            node: the node.
            role: its part in the graph, such as "repair".
            collect: what it runs; its class if there is nothing else to say.
            is_told: whether a parameter, by its name, has to do with what it runs.

        Raises:
            InputError: a parameter was given that the node does not have.
        """
        self._node = node
        self._role = role
        self._collect = collect or (lambda: Running(role))
        self._is_told = is_told
        self._ignored = refuse_unknown(node)
        self._told: Announcement | None = None
        self._publisher = node.create_publisher(DiagnosticArray, topics.CONFIGURATION, qos.LATCHED)
        node.add_post_set_parameters_callback(self._on_parameters)

    @property
    def announcement(self) -> Announcement:
        """As it is now."""
        kind = type(self._node)
        running = self._collect()
        module = kind.__module__
        if module == "__main__":  # started by python -m
            module = getattr(getattr(sys.modules[module], "__spec__", None), "name", module)
        values = {"role": self._role, "node_class": f"{module}.{kind.__qualname__}"}
        values |= {"package": f"roadmend {__version__}", **running.values}
        for parameter in map(self._node.get_parameter, sorted(self._node.list_parameters([], 0).names)):
            if self._is_told(parameter.name):
                values[PARAMETER + parameter.name] = json.dumps(_plain(parameter.value))
        if self._ignored:
            values[IGNORED] = json.dumps(self._ignored)
        return Announcement(self._node.get_fully_qualified_name(), running.label, values)

    def announce(self) -> None:
        """Publish it, unless it has been said already."""
        now = self.announcement
        if now == self._told:
            return
        self._told = now
        status = DiagnosticStatus(
            level=DiagnosticStatus.OK,
            name=now.node,
            message=now.label,
            hardware_id="roadmend",
            values=[KeyValue(key=key, value=value) for key, value in now.values.items()],
        )
        message = DiagnosticArray(status=[status])
        message.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(message)

    def _on_parameters(self, _changed: list[Parameter]) -> None:
        if self._told is not None:
            self.announce()


def refuse_unknown(node: Node) -> list[str]:
    """Parameters that were given to all nodes and that this one does not have.

    Raises:
        InputError: this node was given another that it does not have.
    """
    known = node.list_parameters([], 0).names
    shared = json.loads(os.environ.get(SHARED, "[]"))
    given = node._parameter_overrides  # noqa: SLF001 - rclpy tells it nowhere else
    unknown = sorted(set(given) - set(known))
    ours = [name for name in unknown if name not in shared]
    if ours:
        raise unknown_parameter(ours[0], node.get_name(), known)
    return unknown


class Announcements:
    """What is heard on the topic, and who sends the commands."""

    def __init__(self, node: Node, changed: Callable[[], None] = lambda: None) -> None:
        """Listen.

        Args:
            node: who listens.
            changed: called when something new was said or somebody new sends commands.
        """
        self.by_node: dict[str, Announcement] = {}
        self._node = node
        self._changed = changed
        self._senders: dict[Input, list[str]] = {COMMAND: [], REPAIRED: []}
        node.create_subscription(DiagnosticArray, topics.CONFIGURATION, self._on_message, _LISTEN)

    def look(self, *, is_driving: bool) -> None:
        """Note who sends commands; to be called regularly, since those who have gone are not seen any more.

        Args:
            is_driving: whether their commands are driven on; who has gone before that has no part in the run.
        """
        for wanted, senders in self._senders.items():
            there = [*dict.fromkeys(wanted.heard(self._node))]
            now = [*dict.fromkeys([*senders, *there])] if is_driving else there
            if now != senders:
                senders[:] = now
                self._changed()

    @property
    def account(self) -> dict[str, str]:
        """What the run is labelled with; see ``announcement.account``."""
        return account(self.by_node, *self._senders.values())

    def _on_message(self, message: Any) -> None:
        for status in message.status:
            said = Announcement(status.name, status.message, {pair.key: pair.value for pair in status.values})
            if self.by_node.get(status.name) != said:
                self.by_node[status.name] = said
                self._changed()


def _plain(value: Any) -> Any:
    """A parameter's value as JSON has it."""
    return list(value) if isinstance(value, tuple | set) or hasattr(value, "tolist") else value
