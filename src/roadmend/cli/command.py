"""Commands and groups whose help has examples, and which say after an interrupt how to go on."""

import os
import re
import shlex
import shutil
from collections.abc import Sequence
from typing import Any

import click

from roadmend.core.interrupt import InterruptedWorkError
from roadmend.core.resources import clone_folder

_CALLED_AS = "ROADMEND_CALLED_AS"  # set by the script at the root of a clone: the word by which it was called


class ExampleCommand(click.Command):
    """A command with examples at the end of its help.

    Args:
        examples: whole command lines.
        resumes: words to add to a command line that was interrupted so that it goes on with what is finished; empty
            where it goes on by itself, None where nothing is kept.
    """

    def __init__(self, *args: Any, examples: Sequence[str], resumes: str | None = None, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.examples = examples
        self.resumes = resumes

    def invoke(self, ctx: click.Context) -> Any:
        """Run it.

        Raises:
            InterruptedWorkError: Ctrl-C was pressed.
        """
        try:
            return super().invoke(ctx)
        except (KeyboardInterrupt, click.Abort):
            raise InterruptedWorkError(self.resumes) from None

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """The examples, and what the command says besides."""
        _write_examples(self.examples, ctx, formatter)
        super().format_epilog(ctx, formatter)


class Group(click.Group):
    """A group with examples at the end of its help.

    Args:
        examples: whole command lines.
    """

    def __init__(self, *args: Any, examples: Sequence[str], **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.examples = examples

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """The examples, and what the group says besides."""
        _write_examples(self.examples, ctx, formatter)
        super().format_epilog(ctx, formatter)


def _write_examples(examples: Sequence[str], ctx: click.Context, formatter: click.HelpFormatter) -> None:
    """Write a section of a help, one line an example however long, so that it can be copied."""
    called = ctx.find_root().info_name or "roadmend"
    if examples:
        with formatter.section("Examples"):
            for example in examples:
                line = re.sub(r"\broadmend (?=\w)", lambda _: f"{called} ", example)
                formatter.write(f"{'':>{formatter.current_indent}}{line}\n")


def called_as() -> str:
    """How people call the command line, from where they are: the script of a clone, or by its name on the PATH."""
    word = os.environ.get(_CALLED_AS) or "roadmend"
    name = os.path.basename(word)  # noqa: PTH119 - a word of a shell: pathlib would take its "./" away
    return name if shutil.which(name) == word else shlex.quote(word)


def is_clone() -> bool:
    """Whether this is a clone of the project, and not what pip has installed."""
    return clone_folder() is not None
