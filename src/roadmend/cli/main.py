"""The command ``roadmend``."""

import sys
from collections.abc import Sequence

import click

from roadmend import __version__
from roadmend.core.errors import InputError, RoadmendError

_COMMANDS = {
    "run": ("roadmend.cli.run", "run", "Run one episode in the graph: SUMO, policy, repair and recorder."),
    "demo": ("roadmend.cli.demo", "demo", "See a collision repaired: the main job, end to end."),
    "sample": ("roadmend.cli.scenario", "sample", "Draw a scenario of one of the five families."),
    "schema": ("roadmend.cli.scenario", "schema", "Print the JSON schema of a scenario file."),
    "bench": ("roadmend.cli.bench", "bench", "Measure, in ratios."),
    "search": ("roadmend.cli.search", "search", "Find scenarios in which a policy under repair collides."),
    "picture": ("roadmend.cli.picture", "picture", "Draw the scene at one moment of a bag."),
}


class LazyGroup(click.Group):
    """Loads a command's module only when it is called: 'roadmend --help' must not wait for SUMO."""

    def list_commands(self, ctx: click.Context) -> list[str]:  # noqa: ARG002 - click calls it so
        """Names in the order of the table."""
        return [*_COMMANDS]

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:  # noqa: ARG002
        """Load one command."""
        if cmd_name not in _COMMANDS:
            return None
        module_name, name, _ = _COMMANDS[cmd_name]
        module = __import__(module_name, fromlist=[name])
        command: click.Command = getattr(module, name)
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:  # noqa: ARG002
        """The list of commands, without loading them."""
        with formatter.section("Commands"):
            rows = [(name, text) for name, (_, _, text) in _COMMANDS.items()]
            formatter.write_dl([*rows, ("test", "Check the project itself: import rules, lint, types, tests.")])


@click.group(cls=LazyGroup, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110})
@click.version_option(__version__, prog_name="roadmend")
def cli() -> None:
    """Repair a self-driving policy while it drives, and learn from what went wrong."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; every error is one line.

    Returns:
        0, 1 for a failure, 2 for bad input, 130 after an interrupt.
    """
    given = list(sys.argv[1:] if arguments is None else arguments)
    try:
        code = cli.main(given, prog_name="roadmend", standalone_mode=False)
    except InputError as error:
        return _complain(str(error), 2)
    except RoadmendError as error:
        return _complain(str(error), 130 if str(error) == "interrupted" else 1)
    except click.UsageError as error:
        name = error.ctx.command_path if error.ctx is not None else "roadmend"
        return _complain(f"{error.format_message()} (see '{name} --help')", 2)
    except click.ClickException as error:
        return _complain(error.format_message(), 1)
    except (click.Abort, KeyboardInterrupt):
        return _complain("interrupted", 130)
    return int(code or 0)


def _complain(text: str, code: int) -> int:
    print(f"roadmend: {' '.join(text.split())}", file=sys.stderr)
    return code
