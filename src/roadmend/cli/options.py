"""Options that many commands have, and commands that take their options as one object."""

import os
from collections.abc import Callable
from dataclasses import fields
from functools import wraps
from pathlib import Path
from typing import Any, TypeVar, get_args

import click

Settings = TypeVar("Settings")

PATH = click.Path(path_type=Path)
FILE = click.Path(path_type=Path, dir_okay=False)
FOLDER = click.Path(path_type=Path, file_okay=False)
SEED = click.option("--seed", default=0, show_default=True, type=click.IntRange(0, 2**31 - 1))
WORKERS = click.option("--workers", default=os.cpu_count() or 1, show_default="cores", type=click.IntRange(1, 256))
JSON = click.option("--json", "as_json", is_flag=True, help="Print JSON.")


def options_of(kind: type[Settings], name: str = "given") -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Options of a command as one object; further options stay arguments of their own.

    Args:
        kind: a dataclass whose fields are annotated with their options, ``Annotated[int, click.option(...)]``, in the
            order of the help.
        name: of the command's argument that takes the object.
    """
    options = [option for field in fields(kind) for option in get_args(field.type)[1:]]  # type: ignore[arg-type]
    names = [field.name for field in fields(kind)]  # type: ignore[arg-type]

    def decorate(command: Callable[..., Any]) -> Callable[..., Any]:
        @wraps(command)
        def with_settings(**given: Any) -> Any:
            settings = kind(**{each: given.pop(each) for each in names})
            return command(**given, **{name: settings})

        for option in reversed(options):
            with_settings = option(with_settings)
        return with_settings

    return decorate
