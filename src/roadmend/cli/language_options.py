"""Options of the commands that may ask a language model, and what they say of what it took."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import click

from roadmend.cli.options import FILE, PATH, NameType, options_of
from roadmend.language.exchange import Usage
from roadmend.language.models import BACKEND_REGISTRY, EMBEDDED
from roadmend.language.question import ATTEMPTS


@dataclass(frozen=True)
class LanguageChoice:
    """Which backend, and how it is asked."""

    backend: Annotated[
        str, click.option("--backend", default=EMBEDDED, show_default=True, type=NameType(BACKEND_REGISTRY))
    ]
    settings: Annotated[
        Path | None,
        click.option(
            "--settings",
            type=FILE,
            help="YAML file with the endpoint of openai (see config/language); the environment wins.",
        ),
    ]
    recording: Annotated[
        Path | None, click.option("--recording", type=PATH, help="Results of an earlier run, for replay.")
    ]
    attempts: Annotated[
        int,
        click.option(
            "--attempts",
            default=ATTEMPTS,
            show_default=True,
            type=click.IntRange(1, 20),
            help="With a model: answers that a question may take.",
        ),
    ]


language_options = options_of(LanguageChoice, "language")


def show_usage(usage: Mapping[str, Usage]) -> None:
    """Say what language models took; nothing if none was asked."""
    for model, used in usage.items():
        click.echo(f"{model}: {used}")
