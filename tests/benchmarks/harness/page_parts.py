"""Parts of a benchmark's page: one HTML file, and nothing but itself is needed to read it."""

import base64
import html
import io
from collections.abc import Sequence

import matplotlib as mpl
from matplotlib.figure import Figure

from harness.table import Table

_STYLE = """
:root { color-scheme: light; --ink: #1f2328; --muted: #626a72; --line: #d9dde1; --tint: #f5f7f9; --mark: #d55e00; }
* { box-sizing: border-box; }
body { margin: 0; background: #fff; color: var(--ink); font: 16px/1.55 system-ui, sans-serif; }
main { max-width: 1120px; margin: 0 auto; padding: 40px 24px 72px; }
h1 { font-size: 1.9rem; line-height: 1.2; margin: 0 0 8px; }
h2 { font-size: 1.25rem; margin: 48px 0 6px; }
p { max-width: 78ch; margin: 6px 0 14px; }
.note, footer, figcaption { color: var(--muted); font-size: .88rem; }
figure { margin: 18px 0 8px; }
figure img { width: 100%; height: auto; display: block; }
.scroll { overflow-x: auto; border: 1px solid var(--line); border-radius: 6px; }
table { border-collapse: collapse; width: 100%; font-size: .84rem; font-variant-numeric: tabular-nums; }
th, td { padding: 6px 10px; text-align: right; white-space: nowrap; border-bottom: 1px solid var(--line); }
th { background: var(--tint); font-weight: 600; position: sticky; top: 0; }
tr:last-child td { border-bottom: 0; }
td.text, th.text { text-align: left; }
td.long { white-space: normal; min-width: 26ch; }
tr.ours td { font-weight: 600; background: #fdf3ec; }
nav { display: flex; flex-wrap: wrap; gap: 4px 18px; margin: 18px 0 8px; font-size: .9rem; }
a { color: #0a5a9c; }
code { background: var(--tint); padding: 1px 5px; border-radius: 4px; font-size: .88em; overflow-wrap: anywhere; }
footer { margin-top: 56px; border-top: 1px solid var(--line); padding-top: 14px; }
"""

Section = tuple[str, str]  # title and content, HTML


def whole_page(title: str, lead: str, sections: Sequence[Section], foot: str) -> str:
    """A page of sections with links to each.

    Args:
        title: plain text.
        lead: HTML.
        sections: in order.
        foot: HTML.
    """
    links = "".join(f'<a href="#{anchor_of(name)}">{html.escape(name)}</a>' for name, _ in sections)
    body = "".join(
        f'<section id="{anchor_of(name)}"><h2>{html.escape(name)}</h2>{inner}</section>\n' for name, inner in sections
    )
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{html.escape(title)}</title>\n<style>{_STYLE}</style>\n</head>\n<body>\n<main>\n"
        f"<h1>{html.escape(title)}</h1>\n{lead}<nav>{links}</nav>\n{body}"
        f"<footer>{foot}</footer>\n</main>\n</body>\n</html>\n"
    )


def figure_part(figure: Figure, title: str, caption: str) -> str:
    """A chart with its caption, drawn into the page."""
    return (
        f'<figure><img alt="{html.escape(title)}" src="data:image/svg+xml;base64,{_svg(figure)}">'
        f"<figcaption>{html.escape(caption)}</figcaption></figure>"
    )


def _svg(figure: Figure) -> str:
    """The figure in base64; the same figure gives the same text."""
    buffer = io.BytesIO()
    with mpl.rc_context({"svg.hashsalt": "roadmend", "svg.fonttype": "path"}):
        figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    return base64.b64encode(buffer.getvalue()).decode()


def note_part(table: Table) -> str:
    """The note of a table."""
    return f'<p class="note">{html.escape(table.note)}</p>'


def table_part(rows: Sequence[Sequence[str]]) -> str:
    """A table; the first row is the heading."""
    head, *others = rows
    texts = [all(not _is_figure(row[column]) for row in others) for column in range(len(head))]
    lines = ["<tr>" + "".join(_cell("th", c, is_text=t) for c, t in zip(head, texts, strict=True)) + "</tr>"]
    for row in others:
        mark = ' class="ours"' if "ADReFT" in row[:2] and not row[0].startswith("paper") else ""
        lines.append(
            f"<tr{mark}>" + "".join(_cell("td", c, is_text=t) for c, t in zip(row, texts, strict=True)) + "</tr>"
        )
    return f'<div class="scroll"><table>{"".join(lines)}</table></div>'


def _cell(tag: str, text: str, *, is_text: bool) -> str:
    kinds = " ".join(["text"] * is_text + ["long"] * (tag == "td" and len(text) > 60))
    return f"<{tag}{f' class={chr(34)}{kinds}{chr(34)}' if kinds else ''}>{html.escape(text)}</{tag}>"


def _is_figure(text: str) -> bool:
    return text[:1].isdigit() or text[:1] in {"-", "\N{EN DASH}"}


def anchor_of(title: str) -> str:
    """What a section is linked by."""
    return "".join(letter if letter.isalnum() else "-" for letter in title.lower())
