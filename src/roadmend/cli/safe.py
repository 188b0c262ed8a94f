"""``roadmend safe``: from a crash report to scenarios that test the policy."""

import click

from roadmend.cli.lazy import LazyGroup, Table

_COMMANDS: Table = {
    "extract": ("roadmend.cli.safe_extract", "extract", "Read crash reports: what happened, in the scenario language."),
}


@click.group(cls=LazyGroup, table=_COMMANDS)
def safe() -> None:
    """Turn crash reports into scenarios, and test a policy with them."""
