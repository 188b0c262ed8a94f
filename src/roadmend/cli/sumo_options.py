"""Options of the commands that drive in SUMO configurations of anybody's."""

from collections.abc import Callable
from typing import Any

import click

from roadmend.cli.options import PATH, Number

DRIVES = 3  # on each configuration, where an evaluation is not told how many
TIME_LIMIT = 120.0  # [s] of each drive
WARM_UP = 300.0  # [s] of traffic before

WARM_UP_OPTION = click.option(
    "--warm-up",
    type=Number(0.0, 86_400.0),
    help=f"With --sumocfg: seconds of traffic before the ego enters.  [default: {WARM_UP:g}]",
)


def sumocfg(help_text: str, **more: Any) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """The option that names a SUMO configuration, or a network alone."""
    return click.option("--sumocfg", "--net", type=PATH, metavar="FILE", help=help_text, **more)


def time_limit(help_text: str) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """The option that bounds a drive."""
    return click.option("--time-limit", type=Number(0.1, 86_400.0), help=help_text)


def egos(default: str) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """The option that says how many egos drive, one after the other."""
    text = "With --sumocfg: egos on each, that drive one after the other, each in traffic, on a route and from a start"
    return click.option(
        "--egos", type=click.IntRange(1, 100_000), help=f"{text} drawn by its seed.  [default: {default}]"
    )
