"""Charts of how well repair methods repair: effectiveness, intensity, outcomes, dose, families."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from harness.benchmark_tables import methods_of, title_of
from harness.chart_labels import GROUP_COLOUR, add_legend, colour_of, group_handles, label_points, name_methods
from harness.table import DASH
from roadmend.reports.chart_style import INK, MUTED, despine, new_figure

Content = Mapping[str, Any]

_NO_METHODS = {"none", "hindsight", "hindsight_lucky"}
_OUTCOME_COLOUR = {"goal": "#009e73", "time limit": "#e69f00", "off the route": "#cc79a7", "collision": "#d55e00"}


def delta_e_chart(content: Content) -> Figure:
    """ΔE of every method with its interval, the paper's beside it."""
    methods = methods_of(content)[::-1]
    figure, panels = new_figure(content["policies"], 1.2 + 0.34 * len(methods), share_y=True)
    for axes, policy in zip(panels, content["policies"], strict=True):
        for place, method in enumerate(methods):
            figures = content["summary"][policy].get(method)
            theirs = content["paper"]["summary"].get(policy, {}).get(method)
            if theirs is not None:
                axes.plot(theirs["delta_e"], place, marker="D", ms=5.5, mfc="white", mec=MUTED, mew=1.2, zorder=3)
            if figures is None or figures["delta_e"] is None:
                axes.text(1.0, place, "not run", color=MUTED, fontsize=8, va="center", style="italic")
                continue
            colour = colour_of(content, method)
            low, high = figures["intervals"]["delta_e"]
            axes.plot([low, high], [place, place], color=colour, lw=2.2, solid_capstyle="butt", zorder=4)
            axes.plot(figures["delta_e"], place, "o", ms=7, color=colour, zorder=5)
            axes.annotate(
                f"{figures['delta_e']:.1f}",
                (high, place),
                (6, 0),
                textcoords="offset points",
                va="center",
                fontsize=8.5,
                color=INK,
            )
        name_methods(axes, content, methods)
        axes.set_xlim(min(-12.0, axes.get_xlim()[0]), 112.0)
        axes.set_xticks(range(0, 101, 20))
        axes.set_xlabel("ΔE = %Fix - %Deg")
        axes.axvline(0.0, color=MUTED, lw=0.8)
        despine(axes, grid="x")
    handles = [
        *group_handles(content, methods),
        Line2D([], [], marker="D", mfc="white", mec=MUTED, ls="", label="the paper's"),
    ]
    add_legend(figure, handles)
    return figure


def scatter_chart(content: Content) -> Figure:
    """Intensity against ΔE: down and to the right is better."""
    methods = [method for method in methods_of(content) if method != "hindsight_lucky"]
    figure, panels = new_figure(content["policies"], 3.9 * len(content["policies"]), rows=len(content["policies"]))
    for axes, policy in zip(panels, content["policies"], strict=True):
        points = []
        for method in methods:
            figures = content["summary"][policy].get(method)
            if figures is None or figures["intensity"] is None or figures["delta_e"] is None:
                continue
            colour = colour_of(content, method)
            x, y = figures["delta_e"], figures["intensity"]
            across, along = figures["intervals"]["delta_e"], figures["intervals"]["intensity"]  # None of a single case
            axes.plot(across or [x, x], [y, y], color=colour, lw=1.0, alpha=0.55)
            axes.plot([x, x], along or [y, y], color=colour, lw=1.0, alpha=0.55)
            axes.plot(x, y, "o", ms=8 if method == "adreft" else 6, color=colour, zorder=4)
            points.append((x, y, title_of(content, method), colour))
        least = min([0.0, *(point[0] for point in points)])
        axes.set_xlim(least - 4.0, 108.0)
        axes.set_ylim(0.0, 2.0)
        label_points(axes, points)
        axes.set_ylabel("intensity, mean |change| of replaced frames")
        despine(axes, grid="both")
    panels[-1].set_xlabel("ΔE = %Fix - %Deg")
    add_legend(figure, group_handles(content, methods))
    return figure


def outcome_chart(content: Content) -> Figure:
    """How violations end under every method."""
    methods = methods_of(content)[::-1]
    figure, panels = new_figure(content["policies"], 1.2 + 0.34 * len(methods), share_y=True)
    for axes, policy in zip(panels, content["policies"], strict=True):
        for place, method in enumerate(methods):
            figures = content["summary"][policy].get(method)
            if figures is None or figures["fix"] is None:
                axes.text(1.0, place, "not run", color=MUTED, fontsize=8, va="center", style="italic")
                continue
            collided = 100.0 - figures["fix_loose"]
            other = max(0.0, figures["fix_loose"] - figures["fix"] - figures["stopped"])
            left = 0.0
            shares = (figures["fix"], figures["stopped"], other, collided)
            for share, colour in zip(shares, _OUTCOME_COLOUR.values(), strict=True):
                axes.barh(place, share, left=left, color=colour, height=0.66, edgecolor="white", lw=0.6)
                if share >= 7.0:
                    axes.text(
                        left + 0.5 * share,
                        place,
                        f"{share:.0f}",
                        color="white",
                        fontsize=8,
                        ha="center",
                        va="center",
                        fontweight="bold",
                    )
                left += share
        name_methods(axes, content, methods)
        axes.set_xlim(0.0, 100.0)
        axes.set_xlabel("violations [%] that end so")
        despine(axes)
    add_legend(figure, [Patch(fc=colour, label=name) for name, colour in _OUTCOME_COLOUR.items()])
    return figure


def dose_chart(content: Content) -> Figure:
    """Mean dose on violations, with the hindsight bound and its double where there is one."""
    methods = [method for method in methods_of(content) if method not in _NO_METHODS][::-1]
    figure, panels = new_figure(content["policies"], 1.2 + 0.34 * len(methods), share_y=True)
    for axes, policy in zip(panels, content["policies"], strict=True):
        largest = 0.1
        for place, method in enumerate(methods):
            figures = content["summary"][policy].get(method)
            if figures is None or figures["dose_violations"] is None:
                axes.text(0.0, place, " not run", color=MUTED, fontsize=8, va="center", style="italic")
                continue
            on_violations, on_successes = figures["dose_violations"], figures["dose_successes"]
            axes.barh(place + 0.17, on_violations, color=colour_of(content, method), height=0.34)
            ratio = (figures.get("bound") or {}).get("dose_ratio")
            text = f" {on_violations:.2f} s" + (f"   {ratio:.1f} x bound" if ratio is not None else "")
            axes.text(on_violations, place + 0.17, text, fontsize=8, va="center", color=INK)
            largest = max(largest, on_violations)
            if on_successes is not None:
                axes.barh(place - 0.17, on_successes, color=colour_of(content, method), height=0.3, alpha=0.35)
                largest = max(largest, on_successes)
        bound = content["summary"][policy].get("hindsight", {}).get("dose_violations")
        if bound is not None:
            for factor, style in ((1.0, "-"), (2.0, "--")):
                axes.axvline(factor * bound, color=GROUP_COLOUR["bound"], lw=1.4, ls=style, zorder=0)
        name_methods(axes, content, methods)
        axes.set_xlim(0.0, 1.35 * largest)
        axes.set_xlabel("dose [s of full command] a case")
        despine(axes, grid="x")
    handles = [
        Patch(fc=MUTED, label="on violations"),
        Patch(fc=MUTED, alpha=0.35, label="on successes"),
        Line2D([], [], color=GROUP_COLOUR["bound"], label="hindsight bound, violations"),
        Line2D([], [], color=GROUP_COLOUR["bound"], ls="--", label="twice the bound"),
    ]
    add_legend(figure, handles)
    return figure


def family_chart(content: Content) -> Figure:
    """ΔE by method and family, as a heat map."""
    methods, families = methods_of(content), list(content["families"])
    figure, panels = new_figure(content["policies"], 1.0 + 0.34 * len(methods), share_y=True, legend=False)
    for axes, policy in zip(panels, content["policies"], strict=True):
        values = np.full((len(methods), len(families)), np.nan)
        for row, method in enumerate(methods):
            for column, family in enumerate(families):
                figures = content["families"][family][policy].get(method)
                if figures is not None and figures["delta_e"] is not None:
                    values[row, column] = figures["delta_e"]
        axes.imshow(np.ma.masked_invalid(values), cmap="YlGnBu", vmin=0.0, vmax=100.0, aspect="auto")
        for row, column in np.ndindex(*values.shape):
            value = values[row, column]
            if np.isfinite(value):
                colour = "white" if value > 58.0 else INK
                axes.text(column, row, f"{value:.0f}", ha="center", va="center", fontsize=9, color=colour)
            else:
                axes.text(column, row, DASH, ha="center", va="center", fontsize=9, color=MUTED)
        axes.set_xticks(range(len(families)), families)
        axes.set_yticks(range(len(methods)), [title_of(content, method) for method in methods])
        axes.set_xticks(np.arange(-0.5, len(families)), minor=True)
        axes.set_yticks(np.arange(-0.5, len(methods)), minor=True)
        axes.grid(visible=True, which="minor", color="white", lw=1.5)
        axes.tick_params(which="both", length=0)
        for spine in axes.spines.values():
            spine.set_visible(False)
    return figure
