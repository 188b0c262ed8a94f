"""The JSON schema of a scenario as a language model is to answer it, made from the types of the scenario language."""

import types
import typing
from collections.abc import Iterator
from dataclasses import is_dataclass
from enum import StrEnum
from typing import Any

from roadmend.safe.dsl import CrashScenario

_NAMES = {"lanes": "num_lanes", "stem": "stem_direction", "environment": "env"}  # where plain data say it otherwise
_WITHIN = "road"  # its fields stand beside the others in plain data
_OWN = "extras"  # the user's own fields, which no model is asked for
_KINDS = {int: "integer", float: "number", bool: "boolean", str: "string"}


def answer_schema() -> dict[str, Any]:
    """Every field of the language, each to be given, null where it may be open; points in place of an action apart."""
    return _object(CrashScenario)


def _object(kind: type) -> dict[str, Any]:
    properties = dict(_properties(kind))
    return {"type": "object", "properties": properties, "required": [*properties], "additionalProperties": False}


def _properties(kind: type) -> Iterator[tuple[str, dict[str, Any]]]:
    for name, hint in typing.get_type_hints(kind).items():
        if name == _WITHIN:
            yield from _properties(hint)
        elif name != _OWN:
            yield _NAMES.get(name, name), _schema(hint)


def _schema(hint: Any) -> dict[str, Any]:
    """The schema of a type.

    Raises:
        TypeError: the language has come to hold something that this does not know.
    """
    choices = [*typing.get_args(hint)] if isinstance(hint, types.UnionType) else [hint]
    is_open = type(None) in choices
    (kind, *others) = [each for each in choices if each is not type(None) and not _is_points(each)]
    if others:
        raise TypeError(f"{hint} has no schema: a field is of one kind, and perhaps open")
    if typing.get_origin(kind) is tuple:
        return {"type": "array", "items": _object(typing.get_args(kind)[0])}
    if isinstance(kind, type) and is_dataclass(kind):
        return _object(kind)
    if issubclass(kind, StrEnum):
        words: list[str | None] = [word.value for word in kind]
        return {"type": ["string", "null"], "enum": [*words, None]} if is_open else {"type": "string", "enum": words}
    if kind not in _KINDS:
        raise TypeError(f"{hint} has no schema")
    return {"type": [_KINDS[kind], "null"] if is_open else _KINDS[kind]}


def _is_points(hint: Any) -> bool:
    inner = typing.get_args(hint)
    return typing.get_origin(hint) is tuple and not is_dataclass(inner[0])
