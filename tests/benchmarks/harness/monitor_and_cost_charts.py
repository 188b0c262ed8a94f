"""Charts beside the repair itself: monitors, cost, robustness against testing techniques."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from harness.benchmark_tables import monitor_title
from harness.chart_labels import GROUP_COLOUR, add_legend, colour_of, group_handles, label_points, name_methods
from roadmend.reports.chart_style import GRID, INK, MUTED, despine, new_figure

Content = Mapping[str, Any]


def monitor_chart(content: Content) -> Figure | None:
    """Precision against recall of the monitors, with lines of equal F1."""
    policies = [policy for policy in content["policies"] if content["monitor"].get(policy)]
    if not policies:
        return None
    figure, panels = new_figure(policies, 4.6, share_y=True)
    recall = np.linspace(1.0, 100.0, 200)
    for axes, policy in zip(panels, policies, strict=True):
        for f1 in (20, 40, 60, 80):
            inside = recall > f1 / 2.0 + 0.5
            precision = f1 * recall[inside] / (2.0 * recall[inside] - f1)
            shown = precision <= 100.0
            axes.plot(recall[inside][shown], precision[shown], color=GRID, lw=1.0, zorder=0)
            axes.text(100.5, f1 * 100.0 / (200.0 - f1), f"F1 {f1}", fontsize=7.5, color=MUTED, va="center")
        points = []
        for name, figures in content["monitor"][policy].items():
            if figures["precision"] is None or figures["recall"] is None:
                continue
            colour = colour_of(content, name)
            axes.plot(figures["recall"], figures["precision"], "o", ms=8 if name == "adreft" else 6, color=colour)
            points.append((figures["recall"], figures["precision"], monitor_title(content, name), colour))
        for name, theirs in content["paper"]["monitor"].get(policy, {}).items():
            if name == "adreft":
                axes.plot(theirs["recall"], theirs["precision"], marker="D", ms=6, mfc="white", mec=MUTED, mew=1.2)
        axes.set_xlim(0.0, 110.0)
        axes.set_ylim(0.0, 102.0)
        label_points(axes, points)
        axes.set_xlabel("recall [%]")
        despine(axes)
    panels[0].set_ylabel("precision [%]")
    used = [name for policy in policies for name in content["monitor"][policy]]
    theirs = Line2D([], [], marker="D", mfc="white", mec=MUTED, ls="", label="the paper's ADReFT")
    add_legend(figure, [*group_handles(content, used), theirs])
    return figure


def cost_chart(content: Content) -> Figure | None:
    """Median and 99th percentile of one frame, on a logarithmic scale."""
    cost = content["cost"]
    if not cost:
        return None
    methods = list(cost)[::-1]
    figure, (axes,) = new_figure([""], 1.3 + 0.34 * len(methods))
    for place, method in enumerate(methods):
        colour, figures = colour_of(content, method), cost[method]
        axes.barh(place, figures["median_ms"], color=colour, height=0.6)
        axes.plot([figures["p99_ms"]] * 2, [place - 0.3, place + 0.3], color=INK, lw=2.0)
        text = f"  {figures['median_ms']:.3f} ms, p99 {figures['p99_ms']:.3f} ms"
        axes.text(max(figures["p99_ms"], figures["median_ms"]), place, text, fontsize=8, va="center", color=INK)
        theirs = content["paper"]["cost"].get(method, {}).get("mean_ms")
        if theirs is not None:
            axes.plot(theirs, place, marker="D", ms=5.5, mfc="white", mec=MUTED, mew=1.2, zorder=5)
    name_methods(axes, content, methods)
    axes.set_xscale("log")
    low = min(figures["median_ms"] for figures in cost.values())
    high = max(4.0, *(figures["p99_ms"] for figures in cost.values()))
    axes.set_xlim(0.5 * low, 12.0 * high)
    for limit, text in ((1.0, "goal, median"), (3.0, "goal, p99")):
        axes.axvline(limit, color=MUTED, lw=1.0, ls=":", zorder=0)
        axes.text(limit, len(methods) - 0.4, text, fontsize=7.5, color=MUTED, ha="right", va="bottom", rotation=0)
    axes.set_xlabel("one frame with 20 objects, one core [ms]")
    despine(axes, grid="x")
    handles = [
        Patch(fc=MUTED, label="median"),
        Line2D([], [], color=INK, lw=2.0, label="99th percentile"),
        Line2D([], [], marker="D", mfc="white", mec=MUTED, ls="", label="the paper's mean"),
    ]
    add_legend(figure, handles)
    return figure


def robustness_chart(robustness: Content | None, titles: Content) -> Figure | None:
    """Violations found over evaluations, summed over the families: mean of the runs, band from least to most."""
    if not robustness or not robustness["policies"]:
        return None
    policies, techniques = list(robustness["policies"]), robustness["techniques"]
    names = [f"{policy}, {technique}" for policy in policies for technique in techniques]
    figure, panels = new_figure(names, 2.6 * len(policies) + 0.6, rows=len(policies), share_y=True)
    for number, axes in enumerate(panels):
        policy, technique = policies[number // len(techniques)], techniques[number % len(techniques)]
        for method, curves in robustness["policies"][policy][technique].items():
            about = titles.get(method, {"title": method, "group": "rival"})
            colour = GROUP_COLOUR[about["group"]]
            table = np.array(curves["found"], dtype=np.float64)  # (runs, points)
            axes.fill_between(
                curves["evaluations"], table.min(axis=0), table.max(axis=0), color=colour, alpha=0.2, lw=0
            )
            axes.plot(curves["evaluations"], table.mean(axis=0), color=colour, lw=2.0)
            axes.annotate(
                f"{table[:, -1].mean():.0f}",
                (curves["evaluations"][-1], table[:, -1].mean()),
                (4, 0),
                textcoords="offset points",
                va="center",
                fontsize=8.5,
                color=colour,
            )
        axes.margins(x=0.0)
        axes.set_ylim(bottom=0.0)
        despine(axes, grid="y")
        if number % len(techniques) == 0:
            axes.set_ylabel("violations found")
        if number // len(techniques) == len(policies) - 1:
            axes.set_xlabel("scenarios run")
    used = {method for policy in robustness["policies"].values() for curves in policy.values() for method in curves}
    handles = [
        Line2D([], [], color=GROUP_COLOUR[about["group"]], lw=2.0, label=about["title"])
        for method, about in titles.items()
        if method in used
    ]
    add_legend(figure, handles)
    return figure
