"""The command ``roadmend``."""

import sys
from collections.abc import Sequence

import click

from roadmend import __version__
from roadmend.cli.lazy import LazyGroup, Table
from roadmend.core.errors import InputError, RoadmendError

_COMMANDS: Table = {
    "run": ("roadmend.cli.run", "run", "Run one episode in the graph: SUMO, policy, repair and recorder."),
    "demo": ("roadmend.cli.demo", "demo", "See a collision repaired: the main job, end to end."),
    "sample": ("roadmend.cli.scenario", "sample", "Draw a scenario of one of the five families."),
    "schema": ("roadmend.cli.scenario", "schema", "Print the JSON schema of a scenario file."),
    "evaluate": ("roadmend.cli.evaluate", "evaluate", "Measure policies with repair methods in scenarios of yours."),
    "search": ("roadmend.cli.search", "search", "Find scenarios in which a policy collides by its own fault."),
    "corpus": ("roadmend.cli.corpus", "corpus", "Gather, verify and show what policies are trained and measured on."),
    "safe": ("roadmend.cli.safe", "safe", "Turn crash reports into scenarios, and test a policy with them."),
    "train": ("roadmend.cli.train", "train", "Train a driving policy, a repair model or a rival's model."),
    "sera": ("roadmend.cli.sera", "sera", "Learn from the failures that were recorded."),
    "bag": ("roadmend.cli.bag", "bag", "Look into bags, mend them, compare them."),
    "replay": ("roadmend.cli.replay", "replay", "Play a bag: publish what it holds, as it was recorded."),
}


@click.group(
    cls=LazyGroup,
    table=_COMMANDS,
    also=[
        ("bench", "Make this repository's own figures again, in ratios."),
        ("test", "Check the project itself: import rules, lint, types, tests."),
    ],
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110},
)
@click.version_option(__version__, prog_name="roadmend")
def cli() -> None:
    """Repair a self-driving policy while it drives, and learn from what went wrong."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line, with what it was called with unless arguments are given; the exit code is the process's."""
    return run_group(cli, "roadmend", sys.argv[1:] if arguments is None else arguments)


def run_group(group: click.Group, name: str, arguments: Sequence[str]) -> int:
    """Run a command of a group; every error is one line.

    Args:
        group: the commands.
        name: what the group is called on the command line.
        arguments: behind that name.

    Returns:
        0, 1 for a failure, 2 for bad input, 130 after an interrupt.
    """
    try:
        code = group.main([*arguments], prog_name=name, standalone_mode=False)
    except InputError as error:
        return _complain(str(error), 2)
    except RoadmendError as error:
        return _complain(str(error), 130 if str(error) == "interrupted" else 1)
    except click.UsageError as error:
        asked = error.ctx.command_path if error.ctx is not None else name
        return _complain(f"{error.format_message()} (see '{asked} --help')", 2)
    except click.ClickException as error:
        return _complain(error.format_message(), 1)
    except (click.Abort, KeyboardInterrupt):
        return _complain("interrupted", 130)
    return int(code or 0)


def _complain(text: str, code: int) -> int:
    print(f"roadmend: {' '.join(text.split())}", file=sys.stderr)
    return code
