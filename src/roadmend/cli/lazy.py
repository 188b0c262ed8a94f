"""A group of commands that loads a command's module only when that command is called."""

from collections.abc import Mapping, Sequence
from typing import Any

import click
from click.shell_completion import CompletionItem

from roadmend.cli.command import Group
from roadmend.core.errors import InputError
from roadmend.core.extras import extra_missing

Table = Mapping[str, tuple[str, str, str]]  # command -> (module, name in the module, line for the help)


class LazyGroup(Group):
    """Knows its commands from a table: a call for help must not wait for SUMO, numba or torch.

    Args:
        table: the commands, in the order of the help.
        also: further rows of the help (name, line), for what is no command of this group.
        examples: whole command lines, for the end of the help.
    """

    def __init__(
        self,
        *args: Any,
        table: Table,
        also: Sequence[tuple[str, str]] = (),
        examples: Sequence[str] = (),
        **kwargs: Any,
    ) -> None:
        super().__init__(*args, examples=examples, **kwargs)
        self.table = table
        self.also = also

    @property
    def _rows(self) -> list[tuple[str, str]]:
        """Names and lines of all that the help lists."""
        return [*((name, text) for name, (_, _, text) in self.table.items()), *self.also]

    def list_commands(self, ctx: click.Context) -> list[str]:  # noqa: ARG002 - click calls it so
        """Names in the order of the table."""
        return [*self.table]

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:  # noqa: ARG002
        """Load one command; where that needs an extra that is missing, one that tells which.

        Raises:
            ModuleNotFoundError: a module is missing that no extra has.
        """
        if cmd_name not in self.table:
            return None
        module_name, name, text = self.table[cmd_name]
        try:
            module = __import__(module_name, fromlist=[name])
        except ModuleNotFoundError as error:
            return _without_extra(cmd_name, text, extra_missing(error))
        command: click.Command = getattr(module, name)
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """The command that the first argument names.

        Raises:
            click.NoSuchCommand: there is none; names the nearest ones, where click would know those only that it loaded.
        """
        try:
            return super().resolve_command(ctx, args)
        except click.NoSuchCommand:
            names = [name for name, _ in self._rows]
            raise click.NoSuchCommand(args[0], possibilities=names, ctx=ctx) from None

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:  # noqa: ARG002
        """The list of commands, without loading them."""
        if self._rows:
            with formatter.section("Commands"):
                formatter.write_dl(self._rows)

    def shell_complete(self, ctx: click.Context, incomplete: str) -> list[CompletionItem]:
        """Commands that begin so, without loading them, and options."""
        rows = [CompletionItem(name, help=text) for name, text in self._rows if name.startswith(incomplete)]
        return rows + click.Command.shell_complete(self, ctx, incomplete)


def _without_extra(name: str, text: str, refusal: InputError) -> click.Command:
    """Stands for a command that cannot be loaded: it has the line of the list for help, and refuses to run."""

    def refuse() -> None:
        raise refusal

    takes_all = {"ignore_unknown_options": True, "allow_extra_args": True, "help_option_names": ["-h", "--help"]}
    told = f"{text}\n\n  Its options and examples show once this is mended: {refusal}"
    return click.Command(name, context_settings=takes_all, callback=refuse, help=told)
