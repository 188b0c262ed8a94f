"""Parameters of other nodes for Foxglove: as they are now, and changed where their node agrees.

The names that Foxglove sees are those of the node and the parameter, joined by a dot: ``/repair_node.rss.rho``.
"""

import threading
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import Any

from foxglove import Parameter as Shown
from rcl_interfaces.msg import ParameterEvent, ParameterType
from rclpy.node import Node
from rclpy.parameter import Parameter, parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient
from rclpy.task import Future

from roadmend.nodes import qos
from roadmend.recording import topics

PATIENCE_S = 2.0  # [s] of wall time for a node to answer
_NUMBERS: dict[int, Callable[[Any], Any]] = {
    ParameterType.PARAMETER_DOUBLE: float,
    ParameterType.PARAMETER_DOUBLE_ARRAY: lambda row: [*map(float, row)],
}

Tried = Callable[[str, str], None]  # given a parameter's name and why its new value was refused, empty where it was not


class ParameterBridge:
    """Answers Foxglove's questions for parameters; called from the server's threads while the node spins.

    Args:
        node: asks the other nodes in its name.
        names: the nodes to ask, relative to the node's namespace.
        tried: told of every attempt to set a parameter.
        changed: given what any of the nodes has changed, by whomever.
    """

    def __init__(self, node: Node, names: Sequence[str], tried: Tried, changed: Callable[[list[Shown]], None]) -> None:
        self._clients = {
            f"{node.get_namespace().rstrip('/')}/{name}": AsyncParameterClient(node, name) for name in names
        }
        self._tried = tried
        self._changed = changed
        node.create_subscription(ParameterEvent, topics.PARAMETER_EVENTS, self._on_event, qos.PARAMETER_EVENT)

    def get(self, wanted: Sequence[str]) -> list[Shown]:
        """Parameters by their names; all if none is named. What is not there is left out."""
        found: list[Shown] = []
        for node, client in self._clients.items():
            listed = _answer(partial(client.list_parameters, [], 0)) if client.services_are_ready() else None
            if listed is None:
                continue
            # Asked for one that it does not have, a node answers for none.
            names = [name for name in sorted(listed.result.names) if not wanted or f"{node}.{name}" in wanted]
            answer = _answer(partial(client.get_parameters, names))
            if answer is not None:
                found += _shown(f"{node}.", zip(names, answer.values, strict=True))
        return found

    def set(self, asked: Sequence[Shown]) -> list[Shown]:
        """Set parameters one by one; returns what they are afterwards."""
        for parameter in asked:
            self._tried(parameter.name, self._set(parameter.name, parameter.get_value()))
        return self.get([parameter.name for parameter in asked])

    def _set(self, full_name: str, value: Any) -> str:
        """Set one parameter; returns why not, or nothing."""
        node = next((node for node in self._clients if full_name.startswith(f"{node}.")), "")
        if not node:
            return f"no node of that name; there are {', '.join(self._clients)}"
        client, name = self._clients[node], full_name.removeprefix(f"{node}.")
        if not client.services_are_ready():
            return f"{node} is not there"
        present = _answer(partial(client.get_parameters, [name]))
        if present is None:
            return f"{node} does not answer"
        kind = present.values[0].type if present.values else ParameterType.PARAMETER_NOT_SET
        if kind == ParameterType.PARAMETER_NOT_SET:
            return f"{node} has no such parameter"
        try:
            # JSON knows one kind of number: a whole one may be meant for a parameter that is not.
            parameter = Parameter(name, Parameter.Type(kind), _NUMBERS.get(kind, lambda same: same)(value))
        except (TypeError, ValueError):
            return f"{value!r} is no {Parameter.Type(kind).name.lower().replace('_', ' ')}"
        answer = _answer(partial(client.set_parameters, [parameter]))
        if answer is None:
            return f"{node} does not answer"
        result = answer.results[0]
        return "" if result.successful else result.reason or f"{node} refuses it"

    def _on_event(self, event: ParameterEvent) -> None:
        if event.node in self._clients:
            news = [*event.new_parameters, *event.changed_parameters]
            self._changed(_shown(f"{event.node}.", ((one.name, one.value) for one in news)))


def _shown(prefix: str, values: Iterable[tuple[str, Any]]) -> list[Shown]:
    """ROS parameters as Foxglove's; those without a value are left out."""
    plain = ((name, parameter_value_to_python(value)) for name, value in values)
    return [Shown(prefix + name, value=_as_native(value)) for name, value in plain if value is not None]


def _as_native(value: Any) -> Any:
    if isinstance(value, bool | int | float | str):
        return value
    if value and all(isinstance(entry, bytes) for entry in value):
        return b"".join(value)
    return list(value)


def _answer(ask: Callable[..., Future]) -> Any:
    """Ask a service and wait for the answer, which another thread takes in; None if none comes."""
    come = threading.Event()
    future = ask(callback=lambda _future: come.set())
    if not come.wait(PATIENCE_S):
        future.cancel()
        return None
    return future.result()
