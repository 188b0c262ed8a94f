"""The four measures over the generations of a policy: a chart, and a page that needs nothing but itself."""

import html
import io
from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from roadmend.measures.summary import MEASURES, summary_rows
from roadmend.reports.chart_style import INK, MUTED, bare, new_figure

_TITLES = ("Driving Score", "Success Rate [%]", "Efficiency [%]", "Comfortness [%]")
_COLOUR = "#0072b2"
_STYLE = """
body { margin: 0 auto; max-width: 1120px; padding: 32px 24px 64px; color: #1f2328; font: 16px/1.55 system-ui, sans-serif; }
h1 { font-size: 1.7rem; } h2 { font-size: 1.15rem; margin: 32px 0 6px; } svg { width: 100%; height: auto; }
table { border-collapse: collapse; font-size: .86rem; } td, th { padding: 5px 10px; border-bottom: 1px solid #d9dde1; }
td, th { text-align: left; } .note, footer { color: #626a72; font-size: .88rem; }
"""
Generations = Sequence[Mapping[str, Any]]  # as plain data, each with number, summary and what was learned


def cycle_chart(generations: Generations) -> Figure:
    """Each measure over the generations, with 95 % intervals."""
    figure, panels = new_figure(_TITLES, 2.6, legend=False)
    for axes, measure in zip(panels, MEASURES, strict=True):
        _draw(axes, generations, measure)
        axes.set_xlabel("generation")
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        axes.set_ylim(0.0, None if measure == "efficiency" else 107.0)  # of 100, all but the ego's speed against others
        axes.set_xlim(-0.4, max(1, len(generations) - 1) + 0.4)
        bare(axes, "y")
    return figure


def _draw(axes: Axes, generations: Generations, measure: str) -> None:
    known = [(each["number"], each["summary"][measure]) for each in generations]
    known = [(number, value) for number, value in known if value["mean"] is not None]
    if not known:
        axes.text(0.5, 0.5, "nothing to tell", transform=axes.transAxes, ha="center", va="center", color=MUTED)
        return
    numbers, means = [number for number, _ in known], [value["mean"] for _, value in known]
    for number, value in known:
        if value["interval"] is not None:
            axes.plot([number, number], value["interval"], color=_COLOUR, lw=1.4, alpha=0.5, solid_capstyle="butt")
    axes.plot(numbers, means, color=_COLOUR, lw=1.4, marker="o", ms=5)
    for number, mean in zip(numbers, means, strict=True):
        axes.annotate(f"{mean:.1f}", (number, mean), (5, 5), textcoords="offset points", fontsize=8.5, color=INK)


def measure_rows(generations: Generations) -> list[list[str]]:
    """The measures as a table, one row a generation, the heading first."""
    head, *rows = summary_rows({str(each["number"]): each["summary"] for each in generations})
    return [["generation", *head[1:]], *rows]


def cycle_page(generations: Generations, made: str) -> str:
    """The page.

    Args:
        generations: to show.
        made: one line about what made it.
    """
    with io.StringIO() as buffer, mpl.rc_context({"svg.fonttype": "none", "svg.hashsalt": "roadmend"}):
        cycle_chart(generations).savefig(buffer, format="svg", metadata={"Date": None})
        picture = buffer.getvalue()
    picture = picture[picture.index("<svg") :]
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n<title>Generations of a policy</title>\n'
        f"<style>{_STYLE}</style>\n</head>\n<body>\n<h1>Generations of a policy</h1>\n{picture}\n"
        f"{_table(measure_rows(generations))}\n{''.join(map(_section, generations))}"
        f"<footer>{html.escape(made)}</footer>\n</body>\n</html>\n"
    )


def _section(generation: Mapping[str, Any]) -> str:
    learned = [
        ("Failure patterns", generation["patterns"]),
        ("Selected", generation["selected"]),
        ("Notes", [*generation["notes"], *generation["faults"]]),
    ]
    lists = "".join(
        f"<h3>{title}</h3>\n<ul>{''.join(f'<li>{html.escape(each)}</li>' for each in items)}</ul>\n"
        for title, items in learned
        if items
    )
    return f"<h2>Generation {generation['number']}: {html.escape(generation['policy'])}</h2>\n{lists}"


def _table(rows: Sequence[Sequence[str]]) -> str:
    head, *body = (
        "".join(f"<{cell}>{html.escape(text)}</{cell}>" for text in row)
        for cell, row in zip(["th", *["td"] * len(rows)], rows, strict=False)
    )
    return f"<table><tr>{head}</tr>{''.join(f'<tr>{row}</tr>' for row in body)}</table>"
