"""Settings from YAML files and parameters of nodes: checked against a model, and refused in one line.

The line says where, what, and how to mend it; a name that is unknown is answered with the nearest one that is known.
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import is_dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Any, TypeVar, get_args, get_type_hints

from pydantic import BaseModel, ValidationError

from roadmend.core.errors import InputError
from roadmend.core.yaml_file import read_fields

Model = TypeVar("Model", bound=BaseModel)

_UNKNOWN = frozenset({"extra_forbidden", "unexpected_keyword_argument"})  # of a model, and of a dataclass


def read_settings(path: Path, model: type[Model], mend: str) -> Model:
    """Settings from a YAML file; names that it leaves out keep their defaults.

    Args:
        path: the file.
        model: what it holds.
        mend: where the user finds names and ranges.

    Raises:
        InputError: the file cannot be read, is no YAML, or a name or value in it is unknown or out of range.
    """
    return check_settings(read_fields(path, mend), model, str(path), mend)


def check_settings(content: object, model: type[Model], where: str, mend: str) -> Model:
    """Settings from plain data.

    Raises:
        InputError: a name or value is unknown or out of range.
    """
    try:
        return model.model_validate(content)
    except ValidationError as error:
        raise InputError(where, describe(error, model), mend) from None


def check_parameters(values: Mapping[str, Any] | None, model: type[Model], where: str) -> Model:
    """Parameters from plain values; an error names them as they are set: "rss.rho".

    Args:
        values: what differs from the defaults.
        model: the parameters.
        where: whose they are.

    Raises:
        InputError: a name is unknown, or a value is out of its range or of the wrong type.
    """
    try:
        return model.model_validate(dict(values or {}))
    except ValidationError as error:
        place, problem = first_fault(error, model)
        meaning = model.model_fields[place].description if place in model.model_fields else None
        mend = meaning or f"known are: {', '.join(model.model_fields) or 'none'}"
        raise InputError(f"{where}.{place}" if place else where, problem, mend) from None


def describe(error: ValidationError, model: Any = None) -> str:
    """The faults of a validation error as one line: the first one, and how many more there are.

    Args:
        error: what pydantic raised.
        model: the type that was asked for; with it an unknown name gets the nearest known one.
    """
    place, problem = first_fault(error, model)
    more = error.error_count() - 1
    is_short = problem.startswith("is ")
    text = f"field {place}{' ' if is_short else ': '}{problem}" if place else problem
    return text + (f" (and {more} more)" if more else "")


def first_fault(error: ValidationError, model: Any = None) -> tuple[str, str]:
    """Where the first fault of a validation error is, as in "actors[1].speed", and what it is."""
    first = error.errors()[0]
    place = _place(first["loc"])
    if first["type"] == "missing":
        return place, "is missing"
    if first["type"] in _UNKNOWN:
        known = sorted({name for names in _names_at(model, first["loc"][:-1]) for name in names})
        near = get_close_matches(str(first["loc"][-1]), known, n=1)
        return place, "is unknown" + (f", did you mean {near[0]}?" if near else "")
    message = first["msg"].removeprefix("Value error, ")
    message = message[:1].lower() + message[1:]
    given = None if getattr(model, "model_config", {}).get("hide_input_in_errors") else first["input"]
    shown = f" (got {json.dumps(given)})" if isinstance(given, str | int | float | bool) else ""
    return place, message + shown


def _place(location: Sequence[int | str]) -> str:
    place = ""
    for part in location:
        place += f"[{part}]" if isinstance(part, int) else f".{part}" if place else part
    return place


def _names_at(kind: Any, location: Sequence[int | str]) -> Iterator[list[str]]:
    """The names of each model that may stand at a place inside a type."""
    fields = _fields_of(kind)
    if fields and not location:
        yield [*fields]
    elif fields:
        yield from _names_at(fields.get(str(location[0])), location[1:])
    for part in get_args(kind):
        yield from _names_at(part, location)  # of a union
        if location:
            yield from _names_at(part, location[1:])  # behind an index, a key, or the tag of a union


def _fields_of(kind: Any) -> Mapping[str, Any]:
    if isinstance(kind, type) and issubclass(kind, BaseModel):
        return {name: field.annotation for name, field in kind.model_fields.items()}
    return get_type_hints(kind) if isinstance(kind, type) and is_dataclass(kind) else {}
