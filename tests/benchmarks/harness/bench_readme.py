"""``roadmend bench readme``: copy the committed figures into the README."""

import re
from pathlib import Path

import click

from roadmend.core.errors import InputError

_BLOCK = re.compile(r"(<!-- figures: (?P<name>[\w-]+) -->\n).*?(<!-- end of figures -->)", re.DOTALL)


@click.command()
@click.option("--readme", default=Path("README.md"), show_default=True, type=click.Path(path_type=Path))
@click.option(
    "--benchmarks",
    default=Path("tests/benchmarks"),
    show_default=True,
    type=click.Path(path_type=Path, file_okay=False),
)
@click.option("--check", is_flag=True, help="Change nothing; exit code 1 if the README is out of date.")
def readme(readme: Path, benchmarks: Path, *, check: bool) -> int:
    """Copy the tables of tests/benchmarks/NAME.md between the marks in the README."""
    try:
        text = readme.read_text(encoding="utf-8")
    except OSError as error:
        raise InputError(str(readme), f"cannot be read ({error.strerror})", "run this in the project's root") from None

    def fill(match: re.Match[str]) -> str:
        source = benchmarks / f"{match['name']}.md"
        if not source.is_file():
            raise InputError(str(source), "no such file", "run the benchmark with --out tests/benchmarks")
        _, _, table = source.read_text(encoding="utf-8").partition("\n\n")
        return f"{match[1]}{table.strip()}\n{match[3]}"

    filled = _BLOCK.sub(fill, text)
    if check:
        return 0 if filled == text else 1
    readme.write_text(filled, encoding="utf-8")
    return 0
