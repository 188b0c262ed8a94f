"""The four measures over the generations of a policy: a chart, and a page that needs nothing but itself."""

from collections.abc import Mapping, Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from roadmend.measures.summary import MEASURES, summary_rows
from roadmend.reports.chart_style import INK, MUTED, despine, new_figure
from roadmend.reports.page import inline_svg, render

_TITLES = ("Driving Score", "Success Rate [%]", "Efficiency [%]", "Comfortness [%]")
_COLOUR = "#0072b2"
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
        despine(axes, "y")
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
    head, *rows = measure_rows(generations)
    return render(
        "cycle.html",
        title="Generations of a policy",
        chart=inline_svg(cycle_chart(generations)),
        head=head,
        rows=rows,
        generations=generations,
        made=made,
    )
