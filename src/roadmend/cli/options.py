"""Options that many commands have, and commands that take their options as one object."""

import math
import os
import re
from collections.abc import Callable, Sequence
from dataclasses import fields
from functools import wraps
from pathlib import Path
from typing import Any, TypeVar, get_args

import click
from click.shell_completion import CompletionItem

from roadmend.core.bounded_file import open_regular
from roadmend.core.errors import InputError
from roadmend.core.registry import Registry

Settings = TypeVar("Settings")


class NameType(click.ParamType[str]):
    """Names something of a registry in any of its ways; what names nothing is refused here, in the registry's words."""

    def __init__(self, registry: Registry[Any], also: Sequence[str] = ()) -> None:
        """Take the names of a registry, and a few that the command itself knows."""
        self.registry = registry
        self.also = also
        self.name = registry.noun

    def get_metavar(self, param: click.Parameter, ctx: click.Context) -> str:
        """For the help."""
        del param, ctx  # by these names click gives them
        return f"[{'|'.join([*self.registry.names, *self.also, 'MODULE:CLASS', *(['FILE'] if self.registry.models else [])])}]"

    def convert(self, value: str, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """The name as it was given."""
        try:
            if value and value not in self.also:  # the empty text is the default of an option that may be left out
                self.registry.find(value)
        except InputError as error:
            told = f"{error.what}; {error.mend}" if error.where == self.registry.noun else str(error)
            self.fail(told, param, ctx)
        return value

    def shell_complete(self, _context: click.Context, _option: click.Parameter, begun: str) -> list[CompletionItem]:
        """The names that begin so."""
        return [CompletionItem(name) for name in (*self.registry.names, *self.also) if name.startswith(begun)]


class ModelType(click.ParamType[str]):
    """Names a model that ships, or a model file; what names neither is refused by what reads it."""

    name = "model"


class Number(click.FloatRange):
    """A number within a range; no comparison with NaN is true, so that click's own range lets it pass."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The number.

        Raises:
            click.BadParameter: it is none, is not finite, or is outside the range.
        """
        number = super().convert(value, param, ctx)
        if not math.isfinite(number):
            self.fail(f"{value} is not a finite number", param, ctx)
        return number


def only_own(_context: click.Context, _option: click.Parameter, path: Path | None) -> Path | None:
    """For the option of a file to write that says whose it is: only one of roadmend's own makes room for another.

    Raises:
        InputError: somebody else's file is there, or one that may not be read: nobody knows whose it is.
    """
    if path is None:
        return None
    try:
        with open_regular(path) as file:
            begin = file.read(_MARKED_WITHIN)
    except PermissionError:
        raise InputError(str(path), "is there already and cannot be read", "choose another name") from None
    except OSError:  # nothing is there, or what is no file, which what writes tells of
        return path
    if begin and not _MARK.match(begin):
        raise InputError(str(path), "is there already and was not written by roadmend", "choose another name")
    return path


# How a file begins that is written under such a name. The word alone stands in a script that calls roadmend, too.
_MARK = re.compile(
    rb"(\s*#[^\n]*\n)*format: [\"']?roadmend-"  # YAML: scenarios, tuned rivals
    rb"|\s*\{\s*\"format\":\s*\"roadmend-"  # a line of JSON: corpora, exported banks
    rb'|.{8}\{"__metadata__":\{"roadmend":'  # safetensors, behind the length of their header: models
    rb"|SQLite format 3\0.{52}rmba",  # SQLite, with the application's identifier: banks
    re.DOTALL,
)
_MARKED_WITHIN = 1 << 12  # [bytes] from its begin
PATH = click.Path(path_type=Path)
BAGS = click.option("--out", default=Path("bags"), show_default=True, type=PATH, help="Folder for the bag.")
RECORD = click.option("--record/--no-record", default=True, show_default=True)
FILE = click.Path(path_type=Path, dir_okay=False)
FOLDER = click.Path(path_type=Path, file_okay=False)
SEED = click.option("--seed", default=0, show_default=True, type=click.IntRange(0, 2**31 - 1))
_WORKERS_MAX = 256
WORKERS = click.option(
    "--workers",
    default=min(len(os.sched_getaffinity(0)), _WORKERS_MAX),  # click refuses a default that is out of range, too
    show_default="cores",
    type=click.IntRange(1, _WORKERS_MAX),
)
JSON = click.option("--json", "as_json", is_flag=True, help="Print JSON.")
DEVICE = click.option("--device", default="auto", show_default=True, help="auto, cpu or cuda.")
FUTURES_MAX = 1000  # of each intervention
FUTURES = click.option(
    "--futures",
    default=0,
    show_default="not looked at",
    type=click.IntRange(0, FUTURES_MAX),
    help="Tell of each intervention whether it was needed, from so many futures; drives the run again (see 'bag need').",
)
MODEL_OUT = click.option("--out", required=True, type=FILE, callback=only_own, help="Model file to write.")
RESULT_FOLDER = click.option("--out", required=True, type=FOLDER, help="Folder; resumes there.")


def settings_file(help_text: str) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """The option that names a YAML file of settings."""
    return click.option("--config", "file", type=FILE, help=help_text)


def setting_option(help_text: str, metavar: str = "NAME=VALUE") -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """The option that sets one value by name; it may be repeated, and arrives as ``settings``."""
    return click.option("--set", "settings", multiple=True, metavar=metavar, help=f"{help_text}; may be repeated.")


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
