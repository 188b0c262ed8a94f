"""Sections of a benchmark's page: a table or a chart under a title."""

import base64
import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl
from matplotlib.figure import Figure

from harness.table import Table
from roadmend.reports.page import render

TEMPLATES = Path(__file__).parent / "templates"


@dataclass(frozen=True, slots=True)
class Section:
    """A part of the page; what is empty is left out."""

    title: str
    note: str = ""
    rows: Sequence[Sequence[str]] = ()  # the first is the heading
    image: str = ""  # where a browser finds it
    caption: str = ""

    @property
    def anchor(self) -> str:
        """What the section is linked by."""
        return "".join(letter if letter.isalnum() else "-" for letter in self.title.lower())

    @property
    def is_text(self) -> list[bool]:
        """Of each column, whether it holds words, not figures."""
        return [not any(map(_is_figure, column)) for _, *column in zip(*self.rows, strict=True)]

    @staticmethod
    def is_ours(row: Sequence[str]) -> bool:
        """Whether a row is to stand out."""
        return "ADReFT" in row[:2] and not row[0].startswith("paper")


def table_section(table: Table) -> Section:
    """A table with its note."""
    return Section(table.title, table.note, table.rows)


def chart_section(title: str, caption: str, figure: Figure) -> Section:
    """A chart with its caption, drawn into the page; the same figure gives the same text."""
    buffer = io.BytesIO()
    with mpl.rc_context({"svg.hashsalt": "roadmend", "svg.fonttype": "path"}):
        figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    image = f"data:image/svg+xml;base64,{base64.b64encode(buffer.getvalue()).decode()}"
    return Section(title, image=image, caption=caption)


def render_sections(template: str, title: str, sections: Sequence[Section], **values: object) -> str:
    """A page of sections with links to each.

    Args:
        template: name of a file in the folder ``templates`` that extends sections.html.
        title: of the page.
        sections: in order.
        values: what the template asks for besides.
    """
    return render(TEMPLATES / template, title=title, sections=sections, **values)


def _is_figure(text: str) -> bool:
    return text[:1].isdigit() or text[:1] in {"-", "\N{EN DASH}"}
