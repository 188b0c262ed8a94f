"""Options that the commands of ``roadmend sera`` share."""

from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Any

import click

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
JSON = click.option("--json", "as_json", is_flag=True, help="Print JSON.")


def filter_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """One option for each group of the filters, to be repeated; ``filters_of`` takes what they give."""
    for group in reversed(fields(Filters)):
        text = f"Only scenarios with this {group.name}; may be repeated."
        command = click.option(f"--{group.name}", multiple=True, help=text)(command)
    return command


def filters_of(given: dict[str, tuple[str, ...]]) -> Filters:
    """The filters that the options stand for.

    Raises:
        InputError: a group has no such value.
    """
    return Filters(**given)


def set_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Options of an evaluation set: random scenarios, or a corpus."""
    options = [
        click.option(
            "--scenarios", type=click.IntRange(1, 100_000), help="Random scenarios of each family.  [default: 20]"
        ),
        click.option("--first-seed", type=click.IntRange(0, 2**30), help="Of the random scenarios.  [default: 0]"),
        click.option(
            "--corpus", type=click.Path(path_type=Path, dir_okay=False), help="Its cases instead of random scenarios."
        ),
        click.option("--split", type=click.Choice(SPLITS), help="Of the corpus.  [default: all]"),
    ]
    for option in reversed(options):
        command = option(command)
    return command
