"""A group of commands that loads a command's module only when that command is called."""

from collections.abc import Mapping, Sequence
from typing import Any

import click

Table = Mapping[str, tuple[str, str, str]]  # command -> (module, name in the module, line for the help)


class LazyGroup(click.Group):
    """Knows its commands from a table: a call for help must not wait for SUMO, numba or torch.

    Args:
        table: the commands, in the order of the help.
        also: further rows of the help (name, line), for what is no command of this group.
    """

    def __init__(self, *args: Any, table: Table, also: Sequence[tuple[str, str]] = (), **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.table = table
        self.also = also

    def list_commands(self, ctx: click.Context) -> list[str]:  # noqa: ARG002 - click calls it so
        """Names in the order of the table."""
        return [*self.table]

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:  # noqa: ARG002
        """Load one command."""
        if cmd_name not in self.table:
            return None
        module_name, name, _ = self.table[cmd_name]
        module = __import__(module_name, fromlist=[name])
        command: click.Command = getattr(module, name)
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:  # noqa: ARG002
        """The list of commands, without loading them."""
        rows = [(name, text) for name, (_, _, text) in self.table.items()]
        if rows or self.also:
            with formatter.section("Commands"):
                formatter.write_dl([*rows, *self.also])
