"""Options that the commands of ``roadmend sera`` share."""

from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Any

import click

from roadmend.sera.facets import Filters

BANK = click.option(
    "--bank", "bank_file", required=True, type=click.Path(path_type=Path, dir_okay=False), help="Bank to read."
)
PATTERN = click.option(
    "--pattern", "patterns", required=True, multiple=True,
    help="What is looked for: a JSON or YAML file of failure patterns, or words. May be repeated.",
)  # fmt: skip
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
