"""``roadmend safe``: from a crash report to scenarios that test the policy."""

import click

from roadmend.cli.lazy import LazyGroup, Table

_COMMANDS: Table = {
    "extract": ("roadmend.cli.safe_extract", "extract", "Read crash reports: what happened, in the scenario language."),
    "build": ("roadmend.cli.safe_build", "build", "Build the scenarios of crash reports."),
    "test": ("roadmend.cli.safe_test", "safe_test", "Drive the scenarios of crash reports with a policy."),
    "reproduce": ("roadmend.cli.safe_reproduce", "reproduce", "Search for the crash that a report describes."),
    "export": ("roadmend.cli.safe_export", "export", "Write a scenario as ASAM OpenSCENARIO and OpenDRIVE."),
}


@click.group(cls=LazyGroup, table=_COMMANDS)
def safe() -> None:
    """Turn crash reports into scenarios, and test a policy with them."""
