"""Options of the commands that may ask a language model."""

from collections.abc import Callable, Collection
from pathlib import Path
from typing import Any

import click

from roadmend.language.question import ATTEMPTS


def language_options(backends: Collection[str]) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Options ``--backend``, ``--settings``, ``--recording`` and ``--attempts``."""
    options = [
        click.option("--backend", default="embedded", show_default=True, type=click.Choice([*backends])),
        click.option(
            "--settings",
            type=click.Path(path_type=Path, dir_okay=False),
            help="YAML file with the endpoint of openai (see config/language); the environment wins.",
        ),
        click.option("--recording", type=click.Path(path_type=Path), help="Results of an earlier run, for replay."),
        click.option(
            "--attempts",
            default=ATTEMPTS,
            show_default=True,
            type=click.IntRange(1, 20),
            help="With a model: answers that a question may take.",
        ),
    ]

    def decorate(command: Callable[..., Any]) -> Callable[..., Any]:
        for option in reversed(options):
            command = option(command)
        return command

    return decorate
