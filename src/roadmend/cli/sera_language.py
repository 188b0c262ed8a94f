"""What the commands of ``roadmend sera`` that may ask a language model share."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import click

from roadmend.core.errors import InputError
from roadmend.core.whole_file import write_text
from roadmend.language.exchange import ENDING
from roadmend.sera.backends import Backend


def open_backend(name: str, settings: Path | None, recording: Path | None, attempts: int, out: Path | None) -> Backend:
    """The backend that the options stand for.

    Raises:
        InputError: it lacks something, or there is no place for what a language model is asked.
    """
    backend = Backend.open(name, settings, recording, attempts)
    if backend.model is not None and out is None:
        raise InputError(f"backend {name}", "has no place for what is said", "name a file with --out")
    return backend


@contextmanager
def keeping_exchanges(backend: Backend, out: Path | None) -> Iterator[None]:
    """Writes beside the output what was said to a language model, also when nothing comes of it.

    Raises:
        InputError: the place cannot be written.
    """
    try:
        yield
    finally:
        if out is not None and backend.model is not None and backend.model.exchanges:
            write_text(out.with_suffix(ENDING), backend.exchanges())


def show_usage(backend: Backend) -> None:
    """Say what a language model took; nothing if none was asked."""
    for model, used in backend.usage().items():
        click.echo(f"{model}: {used}")
