"""Options that several benchmarks have, and where their plans are."""

from collections.abc import Iterable, Sequence
from pathlib import Path

import click

from roadmend.core.errors import InputError

PLANS = Path(__file__).parents[1]
COMMITTED = click.option(
    "--committed",
    default=Path("tests/benchmarks"),
    show_default=True,
    type=click.Path(path_type=Path, file_okay=False),
    help="Folder of the committed figures.",
)
CACHED_WORK = click.option(
    "--work",
    type=click.Path(path_type=Path, file_okay=False),
    help="Folder for finished work; an interrupted run goes on.  [default: in the user's cache]",
)


def listed_names(text: str | None, default: Iterable[str], known: Iterable[str], where: str) -> tuple[str, ...]:
    """Names that an option has separated by commas, in the order of what is known; the default where it was not given.

    Raises:
        InputError: there is no such name.
    """
    chosen = [*default] if text is None else [part.strip() for part in text.split(",")]
    return known_names(chosen, known, where)


def known_names(chosen: Sequence[str], known: Iterable[str], where: str) -> tuple[str, ...]:
    """Names in the order of what is known, each once.

    Raises:
        InputError: there is no such name.
    """
    names = tuple(known)
    for name in chosen:
        if name not in names:
            raise InputError(where, f"there is no {name!r}", f"choose from {', '.join(names)}")
    return tuple(name for name in names if name in chosen)
