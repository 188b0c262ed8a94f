"""src/doc/parameters.md, from what each node declares: ``python tests/nodes/parameter_page.py --write``."""

import contextlib
import io
import os
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest import mock

from rcl_interfaces.msg import ParameterDescriptor
from rclpy.node import Node

from roadmend.core.markdown import table_text
from roadmend.nodes import foxglove, policy, recorder, repair, replay, safe, sera, sim, viz
from roadmend.nodes.domain import own_domain
from roadmend.policies.registry import POLICY_REGISTRY

PAGE = Path(__file__).parents[2] / "src" / "doc" / "parameters.md"
NODES = (sim, policy, repair, recorder, viz, foxglove, replay, safe, sera)
_UNKNOWN = "no_such_parameter"  # a node that is given one declares all that it has, then refuses and ends
_OF_RCLPY = {"use_sim_time", "start_type_description_service"}  # every node has these
_HEAD = """# Parameters

What the nodes declare: read them with `ros2 param describe`, set them with `--ros-args -p NAME:=VALUE` or
`--ros-args --params-file FILE`, behind `roadmend run` and `roadmend repair` too. A name that a node does not have ends it
with the nearest one that it has. Those marked *live* can be changed while the node runs, all others are fixed once it has started. What a node really runs with
it announces on `configuration`, and bags keep that. Defaults are the plain ones: `repair_node` with `policy` set takes the
settings made for that policy (`config/repair`) instead.

This page is written from the nodes by `python tests/nodes/parameter_page.py --write`.
"""


@dataclass(frozen=True)
class Declared:
    """One parameter as a node declared it."""

    name: str
    default: Any
    descriptor: ParameterDescriptor


def declared(module: Any, *given: str) -> list[Declared]:
    """What the node of a module declares, in its order.

    Args:
        module: the node's.
        given: parameters it is started with, as NAME:=VALUE.
    """
    found: list[Declared] = []
    plain = Node.declare_parameter

    def note(node: Node, name: str, value: Any = None, descriptor: Any = None, *rest: Any, **more: Any) -> Any:
        if name not in _OF_RCLPY:
            found.append(Declared(name, value, descriptor))
        return plain(node, name, value, descriptor, *rest, **more)

    arguments = [part for each in (*given, f"{_UNKNOWN}:=1") for part in ("-p", each)]
    with mock.patch.object(Node, "declare_parameter", note), contextlib.redirect_stderr(io.StringIO()) as said:
        code = module.main(["node", "--ros-args", *arguments])
    if code != 2 or f"parameter {_UNKNOWN}" not in said.getvalue():
        raise RuntimeError(f"{module.__name__} ended with {code}: {said.getvalue()}")
    return found


def page() -> str:
    """The whole page, as the nodes would have it."""
    parts = [_HEAD]
    for module in NODES:
        starts = [f"policy:={found.label}" for found in POLICY_REGISTRY] if module is policy else [""]
        listed = [each for start in starts for each in declared(module, *filter(None, [start]))]
        unique = {each.name: each for each in listed}
        name = f"{module.__name__.rpartition('.')[2]}_node"
        rows = [["parameter", "default", "may be", "meaning"], *(_row(each) for each in unique.values())]
        parts.append(f"\n## {name}\n\n{table_text(rows)}\n")
    return "".join(parts)


def _row(each: Declared) -> list[str]:
    meaning = each.descriptor.description
    return [
        f"`{each.name}`",
        _value(each.default),
        _range(each),
        meaning + ("" if each.descriptor.read_only else " *Live.*"),
    ]


def _value(value: Any) -> str:
    if value in ("", [""], []):
        return "empty"
    if isinstance(value, bool):
        return str(value).lower()
    return (
        ", ".join(map(str, value))
        if isinstance(value, list)
        else f"{value:g}"
        if isinstance(value, float)
        else str(value)
    )


def _range(each: Declared) -> str:
    descriptor = each.descriptor
    if descriptor.additional_constraints:
        return descriptor.additional_constraints
    for bounds in (*descriptor.integer_range, *descriptor.floating_point_range):
        low = "" if abs(bounds.from_value) > 1e18 else f"{bounds.from_value:g}"
        high = "" if abs(bounds.to_value) > 1e18 else f"{bounds.to_value:g}"
        return f"{low} to {high}" if low and high else f"from {low}" if low else f"up to {high}"
    kind = each.default[0] if isinstance(each.default, list) else each.default
    word = {bool: "true, false", str: "text", int: "whole number", float: "number"}[type(kind)]
    return f"list of {word}" if isinstance(each.default, list) else word


@contextlib.contextmanager
def apart() -> Iterator[None]:
    """A domain and a working folder of its own, so that no node is seen by others or leaves anything behind."""
    with tempfile.TemporaryDirectory() as folder, own_domain() as domain:
        settings = {"ROS_LOG_DIR": folder, "ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
        with mock.patch.dict(os.environ, settings), contextlib.chdir(folder):
            yield


if __name__ == "__main__":
    with apart():
        text = page()
    if "--write" in sys.argv:
        PAGE.write_text(text, encoding="utf-8")
    sys.exit(text != PAGE.read_text(encoding="utf-8"))
