"""What the commands of ``roadmend sera`` share: options, and asking a language model."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, fields
from functools import wraps
from pathlib import Path
from typing import Annotated, Any

import click

from roadmend.cli.options import FILE, options_of
from roadmend.core.errors import InputError
from roadmend.core.whole_file import write_text
from roadmend.language.exchange import ENDING
from roadmend.sera.backends import Backend
from roadmend.sera.facets import Filters
from roadmend.world.corpus import SPLITS

BANK = click.option(
    "--bank", "bank_file", required=True, type=click.Path(path_type=Path, dir_okay=False), help="Bank to read."
)
PATTERN = click.option(
    "--pattern",
    "patterns",
    required=True,
    multiple=True,
    help="What is looked for: a JSON or YAML file of failure patterns, or words. May be repeated.",
)
EMBEDDER = click.option(
    "--embedder",
    help="That the bank must have been made with; needed where it is code of yours, which is not run otherwise.",
)


def filter_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """One option for each group of the filters, to be repeated; the command gets as ``terms`` what ``filters_of`` takes."""
    groups = [field.name for field in fields(Filters)]

    @wraps(command)
    def with_terms(**given: Any) -> Any:
        return command(terms={group: given.pop(group) for group in groups}, **given)

    for group in reversed(groups):
        text = f"Only scenarios with this {group}; may be repeated."
        with_terms = click.option(f"--{group}", multiple=True, help=text)(with_terms)
    return with_terms


def filters_of(given: dict[str, tuple[str, ...]]) -> Filters:
    """The filters that the options stand for.

    Raises:
        InputError: a group has no such value.
    """
    return Filters(**given)


@dataclass(frozen=True)
class SetChoice:
    """An evaluation set: random scenarios, or a corpus."""

    scenarios: Annotated[
        int | None,
        click.option(
            "--scenarios", type=click.IntRange(1, 100_000), help="Random scenarios of each family.  [default: 20]"
        ),
    ]
    first_seed: Annotated[
        int | None,
        click.option("--first-seed", type=click.IntRange(0, 2**30), help="Of the random scenarios.  [default: 0]"),
    ]
    corpus: Annotated[Path | None, click.option("--corpus", type=FILE, help="Its cases instead of random scenarios.")]
    split: Annotated[
        str | None, click.option("--split", type=click.Choice(SPLITS), help="Of the corpus.  [default: all]")
    ]


set_options = options_of(SetChoice, "chosen")


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
