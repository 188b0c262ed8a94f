"""A table of text for people: rows under a title, as Markdown or as a part of a page."""

from collections.abc import Sequence
from dataclasses import dataclass

from roadmend.core.markdown import table_text

DASH = "\N{EN DASH}"


@dataclass(frozen=True, slots=True)
class Table:
    """Rows of text under a title; the first row is the heading."""

    title: str
    note: str
    rows: tuple[tuple[str, ...], ...]

    def markdown(self, level: int = 2) -> str:
        """As Markdown."""
        return f"{'#' * level} {self.title}\n\n{self.note}\n\n{table_text(self.rows)}"


def number(value: float | None, digits: int = 1) -> str:
    """A figure, or a dash where there is none."""
    return DASH if value is None else f"{value:.{digits}f}"


def span(interval: Sequence[float] | None, digits: int = 1) -> str:
    """An interval, or a dash where there is none."""
    return DASH if interval is None else f"{interval[0]:.{digits}f} .. {interval[1]:.{digits}f}"
