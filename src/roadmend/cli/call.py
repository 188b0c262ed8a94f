"""The call of a command once more, for the account of what made a figure."""

import shlex
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import Any

import click
from click.core import ParameterSource

from roadmend.cli.options import ModelType, NameType

# Where it goes, whether it goes on, and how it is shown: no figure hangs on them.
_ASIDE = ("out", "work", "workers", "resume", "as_json", "with_page")


def call_again(always: Collection[str] = (), *, with_places: bool = True) -> str:
    """The command under way with all that it was given and that figures hang on, ready to be pasted.

    Args:
        always: names of parameters that are told although they have their default.
        with_places: whether files are told with their folders; in what is passed on, as models are, those of this
            machine say nothing.
    """
    context = click.get_current_context()
    words = list[str]()
    for parameter in context.command.params:
        name = parameter.name or ""
        is_told = name in always or context.get_parameter_source(name) is not ParameterSource.DEFAULT
        if is_told and name not in _ASIDE:
            words += _words(parameter, context.params[name], with_places=with_places)
    level = context
    while level.parent is not None:
        words.insert(0, level.info_name or "")
        level = level.parent
    return shlex.join(["./roadmend", *words])


def _words(parameter: click.Parameter, given: Any, *, with_places: bool) -> Iterator[str]:
    values = given if isinstance(given, tuple | list) else (given,)
    if not with_places:
        is_named = isinstance(parameter.type, NameType | ModelType)  # what they name may be a file
        values = [Path(each).name if is_named or isinstance(each, Path) else each for each in values]
    if isinstance(parameter, click.Argument):
        yield from map(str, values)
    elif isinstance(parameter, click.Option) and parameter.is_flag:
        yield (parameter.opts if given else parameter.secondary_opts)[0]
    else:
        for value in values:
            yield from (parameter.opts[0], str(value))
