"""ROS arguments that a whole graph is given, without ROS: to whom they are addressed, and whether anybody has them."""

import json
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from difflib import get_close_matches
from itertools import pairwise
from pathlib import Path
from typing import Any

from roadmend.core.errors import InputError
from roadmend.core.yaml_file import read_fields
from roadmend.nodes.announcement import Announcement

SHARED = "ROADMEND_SHARED_PARAMETERS"  # environment variable: JSON list of parameters that were given to all nodes
IGNORED = "ignored"  # key of an announcement: what of these the node does not have; a JSON list
NODES = ("sim", "policy", "repair", "recorder", "viz", "foxglove", "replay", "safe", "sera")
_PARAMETER, _REMAP, _FILE = ("-p", "--param"), ("-r", "--remap"), "--params-file"
_LEAF = "ros__parameters"


def as_yaml(value: Any) -> str:
    """A parameter's value as rcl's YAML reader takes it on the command line; texts are quoted so that they stay texts."""
    return json.dumps(value, ensure_ascii=False)  # it knows no surrogates


def shared_parameters(given: Sequence[str]) -> set[str]:
    """Names of the parameters that are addressed to all nodes.

    Raises:
        InputError: a file of parameters cannot be read.
    """
    return {name for node, name in _addressed(given) if node in ("", "/**") and name}


def check_addressees(given: Sequence[str]) -> None:
    """Look whether what is addressed to one node is addressed to one that there is.

    Raises:
        InputError: there is no such node, all nodes were to have one name, or a file of parameters cannot be read.
    """
    renamed = []
    for option, word in pairwise(given):
        if option in _REMAP and (":__node:=" in word or word.startswith("__node:=")):
            node, _, name = word.rpartition("__node:=")
            if not node:
                raise InputError("--ros-args", f"{word} gives all nodes one name", f"write policy_node:__node:={name}")
            renamed.append(name)
    known = [*(f"{node}_node" for node in NODES), *renamed]
    for node in (pattern.rpartition("/")[2] for pattern, _ in _addressed(given)):
        if node and "*" not in node and node not in known:
            near = get_close_matches(node, known, n=1)
            what = f"there is no node {node!r}" + (f", did you mean {near[0]}?" if near else "")
            raise InputError("--ros-args", what, f"choose one of {', '.join(known)}")


def check_taken(given: Sequence[str], announced: Collection[Announcement], started: int) -> None:
    """Look whether what was given has reached somebody who has it.

    Args:
        given: the arguments.
        announced: by the nodes of the graph.
        started: how many there are; before all have been heard of, nothing is refused.

    Raises:
        InputError: no node has a parameter of this name, or the node that it is for has another namespace.
    """
    ours = [one for one in announced if one.is_ours]
    if len(ours) < started:
        return
    for pattern, name in _addressed(given):
        meant = [one.node for one in ours if one.node.rpartition("/")[2] == pattern.rpartition("/")[2]]
        if name and meant and not any(_matches(pattern, node) for node in meant):
            what = f"{name} is for {pattern}, but the node is {meant[0]}"
            mend = f"set it in a --params-file, in a section {meant[0]}, or for all nodes, without the name of one"
            raise InputError("--ros-args", what, mend)
    nobody = set.intersection(*(set(json.loads(one.values.get(IGNORED, "[]"))) for one in ours))
    if nobody:
        raise unknown_parameter(min(nobody), "any node", sorted({name for one in ours for name in one.parameters}))


def unknown_parameter(name: str, owner: str, known: Collection[str]) -> InputError:
    """The refusal of a parameter that is not there, with the nearest name that is."""
    near = get_close_matches(name, known, n=1) or [each for each in known if each.rpartition(".")[2] == name][:1]
    what = f"there is none of this name in {owner}" + (f", did you mean {near[0]}?" if near else "")
    return InputError(
        f"parameter {name}", what, "correct or remove it; names are in config/graph.yaml and config/repair"
    )


def _addressed(given: Sequence[str]) -> Iterator[tuple[str, str]]:
    """Pattern of the node's name and name of its parameter, empty for a remap; the pattern is empty where none is named."""
    for option, word in pairwise(given):
        if option in (*_PARAMETER, *_REMAP):
            node, _, name = word.partition(":=")[0].rpartition(":")
            yield node, name if option in _PARAMETER else ""
        elif option == _FILE:
            mend = "give a YAML file of ROS parameters, such as config/graph.yaml"
            yield from _sections(read_fields(Path(word), mend), "")


def _sections(content: Mapping[str, Any], node: str) -> Iterator[tuple[str, str]]:
    for key, value in content.items():
        if key == _LEAF:
            yield node, ""
            yield from ((node, name) for name in _flat(value, ""))
        elif isinstance(value, dict):
            yield from _sections(value, f"{node.rstrip('/')}/{str(key).lstrip('/')}")


def _matches(pattern: str, node: str) -> bool:
    """As rcl does: * is one part of a name and ** any number of them."""
    parts = [{"*": "[^/]+", "**": ".*"}.get(part, re.escape(part)) for part in pattern.strip("/").split("/")]
    return re.fullmatch("/" + "/".join(parts).replace(".*/", "(.*/)?"), node) is not None


def _flat(content: object, prefix: str) -> Iterator[str]:
    if not isinstance(content, dict):
        return
    for key, value in content.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}"
