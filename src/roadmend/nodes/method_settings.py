"""The repair method of repair_node as its parameters ask for it: which, with what, and what is announced of it."""

from collections.abc import Sequence
from typing import Any

from rclpy.node import Node
from rclpy.parameter import Parameter

from roadmend.measures.fitting import fitting, fitting_account
from roadmend.nodes.configuration import Running
from roadmend.nodes.parameters import declare_own, find_named
from roadmend.nodes.provenance import described
from roadmend.repair.method import RepairMethod
from roadmend.repair.registry import METHOD_REGISTRY, METHODS, of_vehicle


class MethodSettings:
    """Declares the parameters of all methods, those of one from outside too, and reads those of the one that runs."""

    def __init__(self, node: Node, method: str, policy: str, full_brake: float) -> None:
        """Declare.

        Args:
            node: whose parameters they are.
            method: the method that is asked for, in any of its ways.
            policy: whose models and tuned settings are its defaults; empty for the plain ones.
            full_brake: deceleration of the ego at brake 1 [m/s2], the default of every method of ours that reckons with it.

        Raises:
            InputError: there is no such method, or a parameter of it has a value that it cannot have.
        """
        self._node, self._method, self._policy = node, method, policy
        self._found = find_named("method", method, METHOD_REGISTRY)
        self._prefix = f"{self._found.label}."
        self._fields: Sequence[str] = ()
        fitted = fitting(method, policy) if policy else {}
        for name, entry in {**METHODS, self._found.label: self._found.entry}.items():
            is_mine = name == self._found.label
            defaults = of_vehicle(name, entry, full_brake) | (fitted if is_mine else {})
            fields = declare_own(node, name, entry.parameters, defaults, is_fixed=False)
            if is_mine:
                self._fields = [*fields]

    def is_told(self, parameter: str) -> bool:
        """Whether a parameter says something of what runs: those of methods that do not run say nothing."""
        return parameter.startswith(self._prefix) or parameter.partition(".")[0] not in METHODS

    def concerns(self, changed: Sequence[Parameter]) -> bool:
        """Whether any of these is a parameter of the method that runs."""
        return any(parameter.name.startswith(self._prefix) for parameter in changed)

    def values(self, changed: Sequence[Parameter] = ()) -> dict[str, Any]:
        """The method's parameters by name, as they are or as they would be with these changed."""
        prefix = self._prefix
        values = {
            name.removeprefix(prefix): self._node.get_parameter(name).value
            for name in (prefix + field for field in self._fields)
        }
        return values | {
            parameter.name.removeprefix(prefix): parameter.value
            for parameter in changed
            if parameter.name.startswith(prefix)
        }

    def running(self, made: RepairMethod | None) -> Running:
        """What is announced of the method as it is now; nothing but its name where it could not be made."""
        if made is None:
            return Running(self._method)
        parameters = self._found.entry.parameters().model_dump() | self.values()
        values = described(self._found, made, parameters)
        account = fitting_account(self._method, self._policy, parameters) if self._policy else ""
        return Running(self._method, values | ({"fitting": account} if account else {}))
