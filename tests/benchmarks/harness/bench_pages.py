"""``roadmend bench pages``: copy the committed figures into the README and the pages of src/doc."""

import re
from pathlib import Path

import click

from harness.summary import summary
from roadmend.core.errors import InputError
from roadmend.core.markdown import table_text
from roadmend.core.whole_file import write_text

_BLOCK = re.compile(r"(<!-- figures: (?P<name>[\w-]+) -->\n).*?(<!-- end of figures -->)", re.DOTALL)
_SUMMARY = "summary"  # the table that is made from several benchmarks


@click.command()
@click.option(
    "--root",
    default=Path(),
    show_default="this folder",
    type=click.Path(path_type=Path, file_okay=False),
    help="The project's root, with README.md and src/doc.",
)
@click.option(
    "--benchmarks",
    default=Path("tests/benchmarks"),
    show_default=True,
    type=click.Path(path_type=Path, file_okay=False),
)
@click.option("--check", is_flag=True, help="Change nothing; exit code 1 if a page is out of date.")
def pages(root: Path, benchmarks: Path, *, check: bool) -> int:
    """Copy the tables of tests/benchmarks/NAME.md between the marks in the README and in src/doc."""
    outdated = 0
    for page in [root / "README.md", *sorted((root / "src" / "doc").glob("*.md"))]:
        try:
            text = page.read_text(encoding="utf-8")
        except OSError as error:
            mend = "run this in the project's root, or name it with --root"
            raise InputError(str(page), f"cannot be read ({error.strerror})", mend) from None
        filled = fill(text, benchmarks)
        if filled != text:
            outdated += 1
            if not check:
                write_text(page, filled)
    return int(check and outdated > 0)


def fill(text: str, benchmarks: Path) -> str:
    """A page with the committed figures between its marks.

    Raises:
        InputError: a page asks for figures that are not there.
    """
    return _BLOCK.sub(lambda match: f"{match[1]}{_figures(match['name'], benchmarks)}\n{match[3]}", text)


def _figures(name: str, benchmarks: Path) -> str:
    if name == _SUMMARY:
        return table_text(summary(benchmarks))
    source = benchmarks / f"{name}.md"
    if not source.is_file():
        raise InputError(str(source), "no such file", "run the benchmark with --out tests/benchmarks")
    _, _, table = source.read_text(encoding="utf-8").partition("\n\n")
    return table.strip()
