"""Topics that others publish: who does, the class of their messages, and the QoS that matches all offers."""

import importlib
from collections.abc import Callable, Sequence
from typing import Any

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

from roadmend.core.errors import InputError
from roadmend.recording.definitions import Definition, find

_UNTOLD = "_NODE_NAME_UNKNOWN"  # rmw's stand-in for the name


def look_up(name: str, types: Sequence[str]) -> tuple[Definition, Any]:
    """Definition and class of a topic's messages.

    Raises:
        InputError: the topic has several types, or its type is not installed.
    """
    if len(types) != 1:
        raise InputError(name, f"has several types, {' and '.join(types)}", "publish one of them elsewhere")
    definition = find(types[0])
    package, _, kind = definition.type_name.split("/")
    try:
        return definition, getattr(importlib.import_module(f"{package}.msg"), kind)
    except (ImportError, AttributeError) as error:
        raise InputError(name, f"its type cannot be imported ({error})", f"install the package {package}") from error


class LookUp:
    """Looks topics up; one that could not be is looked up again once it has other types.

    Args:
        complain: called with why a topic could not be looked up.
    """

    def __init__(self, complain: Callable[[InputError], None]) -> None:
        self.refused: dict[str, str] = {}  # topic and why
        self._types: dict[str, list[str]] = {}  # with which it was refused last
        self._complain = complain

    def is_due(self, name: str, types: list[str]) -> bool:
        """Whether a topic was not refused with these types already."""
        return self._types.get(name) != types

    def find(self, name: str, types: list[str]) -> tuple[Definition, Any] | None:
        """Definition and class of a topic's messages; None where it is refused."""
        try:
            found = look_up(name, types)
        except InputError as error:
            self.refused[name], self._types[name] = str(error), types
            self._complain(error)
            return None
        self.refused.pop(name, None)
        return found


def node_of(endpoint: Any) -> str:
    """The full name of the node that a publisher or subscription belongs to; empty while DDS has not told yet."""
    if endpoint.node_name.startswith(_UNTOLD):
        return ""
    return f"{endpoint.node_namespace.rstrip('/')}/{endpoint.node_name}"


def request_for(offers: Sequence[QoSProfile], depth: int | None = None) -> QoSProfile:
    """What to ask for so that every publisher matches.

    Args:
        offers: what the publishers offer.
        depth: how many messages to keep; None keeps all: DDS then reports what it could not deliver, whereas a full
            keep-last queue drops without a word.
    """
    reliable = all(offer.reliability == ReliabilityPolicy.RELIABLE for offer in offers)
    latched = all(offer.durability == DurabilityPolicy.TRANSIENT_LOCAL for offer in offers)
    return QoSProfile(
        history=HistoryPolicy.KEEP_ALL if depth is None else HistoryPolicy.KEEP_LAST,
        depth=depth or 0,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )
