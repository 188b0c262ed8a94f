"""``roadmend completion``: what makes a shell complete commands, options, names and files."""

import click
from click.shell_completion import get_completion_class

from roadmend.cli.command import ExampleCommand
from roadmend.core.errors import RoadmendError

VARIABLE = "_ROADMEND_COMPLETE"  # by which the shell asks; click derives it from the name of the command


@click.command(
    cls=ExampleCommand,
    examples=[
        'eval "$(roadmend completion bash)"    # in ~/.bashrc',
        'eval "$(roadmend completion zsh)"    # in ~/.zshrc',
        "roadmend completion fish > ~/.config/fish/completions/roadmend.fish",
    ],
)
@click.argument("shell", type=click.Choice(["bash", "zsh", "fish"]))
@click.pass_context
def completion(context: click.Context, shell: str) -> None:
    """Print the lines that make a shell complete commands, options, names and files with TAB.

    bash completes ./roadmend too; for zsh and fish the script of a clone has to be on the PATH as roadmend, for instance
    by a link to it in ~/.local/bin.
    """
    kind = get_completion_class(shell)
    if kind is None:
        raise RoadmendError(f"this release of click knows no completion for {shell}")
    click.echo(kind(context.find_root().command, {}, "roadmend", VARIABLE).source(), nl=False)
