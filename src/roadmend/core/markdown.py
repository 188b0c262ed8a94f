"""Tables in Markdown."""

from collections.abc import Sequence


def table_text(rows: Sequence[Sequence[str]]) -> str:
    """A table, without a line break at its end; the first row is the heading."""
    lines = [rows[0], ["---"] * len(rows[0]), *rows[1:]]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines)
