"""Options of the commands that may ask a language model."""

from collections.abc import Callable, Collection
from dataclasses import dataclass
from functools import wraps
from pathlib import Path
from typing import Any

import click

from roadmend.cli.options import FILE, PATH
from roadmend.language.question import ATTEMPTS


@dataclass(frozen=True)
class LanguageChoice:
    """Which backend, and how it is asked."""

    backend: str
    settings: Path | None
    recording: Path | None
    attempts: int


def language_options(backends: Collection[str]) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Options ``--backend``, ``--settings``, ``--recording`` and ``--attempts``, which the command gets as ``language``."""
    options = [
        click.option("--backend", default="embedded", show_default=True, type=click.Choice([*backends])),
        click.option(
            "--settings",
            type=FILE,
            help="YAML file with the endpoint of openai (see config/language); the environment wins.",
        ),
        click.option("--recording", type=PATH, help="Results of an earlier run, for replay."),
        click.option(
            "--attempts",
            default=ATTEMPTS,
            show_default=True,
            type=click.IntRange(1, 20),
            help="With a model: answers that a question may take.",
        ),
    ]

    def decorate(command: Callable[..., Any]) -> Callable[..., Any]:
        @wraps(command)
        def with_choice(
            *, backend: str, settings: Path | None, recording: Path | None, attempts: int, **given: Any
        ) -> Any:
            return command(language=LanguageChoice(backend, settings, recording, attempts), **given)

        for option in reversed(options):
            with_choice = option(with_choice)
        return with_choice

    return decorate
