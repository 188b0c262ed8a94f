"""What a benchmark does with its figures in the end."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

from roadmend.cli.output import show_rows
from roadmend.reports.result_files import write_report


@dataclass(frozen=True, slots=True)
class Figures:
    """The result of a benchmark."""

    name: str  # of the files
    title: str
    content: Mapping[str, Any]  # what JSON can hold, "provenance" among it
    rows: Sequence[Sequence[str]]  # for people; the first is the heading

    def publish(self, out: Path | None, *, as_json: bool) -> None:
        """Write NAME.json and NAME.md into a folder if one is given, and print JSON or the table.

        Raises:
            InputError: the folder cannot be written.
        """
        if out is not None:
            write_report(out, self.name, self.title, self.content, self.rows)
        if as_json:
            click.echo(json.dumps(self.content, indent=2))
        else:
            show_rows(self.rows)
