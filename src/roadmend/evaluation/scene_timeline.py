"""The course of a whole episode as a strip: speed, distance, score and actions over time."""

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from roadmend.core.repair import RepairStatus
from roadmend.evaluation.scene_style import STATUS_COLOUR, TRIGGER_COLOUR

Floats = NDArray[np.float64]

INK, MUTED, RULE = "#22252b", "#5d636e", "#dddfe3"
SPEED_COLOUR = STATUS_COLOUR[RepairStatus.PASS]
REPAIRED_COLOUR = STATUS_COLOUR[RepairStatus.REPAIRED]
POLICY_COLOUR = "#7b3fe4"
SCORE_COLOUR = "#0072b2"
LEFT, RIGHT = 0.085, 0.87  # share of the width at which the plots begin and end
GAP = 0.16  # of a row's height, between rows


@dataclass(frozen=True, slots=True, eq=False)
class Timeline:
    """One value a tick, shape (T,) each; NaN where there is none."""

    time: Floats  # [s] rising
    speed: Floats  # [m/s] of the ego
    distance: Floats  # [m] from the ego's outline to the nearest other
    score: Floats
    threshold: Floats
    policy_action: Floats  # throttle - brake asked by the policy
    final_action: Floats  # throttle - brake sent to the vehicle
    intervened: NDArray[np.bool_]

    def spans(self) -> list[tuple[float, float]]:
        """First and last time [s] of each unbroken stretch of intervention."""
        edges = np.flatnonzero(np.diff(np.concatenate(([False], self.intervened, [False])).astype(np.int8)))
        return [
            (float(self.time[begin]), float(self.time[end - 1]))
            for begin, end in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)
        ]


@dataclass(frozen=True, slots=True, eq=False)
class Series:
    """A line of a row with the name at its end."""

    name: str
    values: Floats
    colour: str
    style: str = "-"


@dataclass(frozen=True, slots=True, eq=False)
class Row:
    """One plot of the strip."""

    label: str
    series: tuple[Series, ...]
    low: float | None = None  # limits of the axis; None: as the data have it
    high: float | None = None


def rows_of(timeline: Timeline) -> list[Row]:
    """The rows for which there are data."""
    if len(timeline.time) < 2:
        return []
    rows = [
        Row("speed\nm/s", (Series("ego", timeline.speed, SPEED_COLOUR),), low=0.0),
        Row("gap\nm", (Series("nearest", np.minimum(timeline.distance, 50.0), INK),), low=0.0),
        Row(
            "score",
            (
                Series("score", timeline.score, SCORE_COLOUR),
                Series("threshold", timeline.threshold, TRIGGER_COLOUR, "--"),
            ),
        ),
        Row(
            "action",
            (
                Series("policy", timeline.policy_action, POLICY_COLOUR, "--"),
                Series("sent", timeline.final_action, INK),
            ),
            low=-1.1,
            high=1.1,
        ),
    ]
    return [row for row in rows if any(np.isfinite(series.values).any() for series in row.series)]


def draw_timeline(
    figure: Figure, timeline: Timeline, box: tuple[float, float, float, float] = (0.0, 0.0, 1.0, 1.0),
    now: float | None = None,
) -> list[Axes]:  # fmt: skip
    """Draw the strip into a part of a figure.

    Args:
        figure: where to draw.
        timeline: the whole episode.
        box: left, bottom, width and height of the part, as shares of the figure.
        now: a time to mark [s].

    Returns:
        The axes of the rows, from the top down; none where the time line has less than two ticks.
    """
    rows = rows_of(timeline)
    left, bottom, width, height = box
    foot = min(0.45 / (figure.get_figheight() * height), 0.4) if height else 0.0
    each = height * (1.0 - foot) / max(len(rows), 1)
    drawn: list[Axes] = []
    for index, row in enumerate(rows):
        low = bottom + height * foot + (len(rows) - 1 - index) * each
        axes = figure.add_axes(
            (left + LEFT * width, low, (RIGHT - LEFT) * width, each * (1.0 - GAP)),
            sharex=drawn[0] if drawn else None,
        )
        _draw_row(axes, timeline, row)
        _mark(axes, timeline, now)
        axes.tick_params(axis="x", labelbottom=index == len(rows) - 1)
        drawn.append(axes)
    if drawn:
        drawn[0].set_xlim(float(timeline.time[0]), float(timeline.time[-1]))
        drawn[-1].set_xlabel("simulation time [s]", fontsize=8.5, color=MUTED, labelpad=2)
    return drawn


def _draw_row(axes: Axes, timeline: Timeline, row: Row) -> None:
    axes.set_ylabel(row.label, fontsize=8.5, color=INK, rotation=0, ha="right", va="center", labelpad=8)
    for place, series in enumerate(row.series):
        if np.isfinite(series.values).any():
            axes.plot(timeline.time, series.values, series.style, color=series.colour, lw=1.5, zorder=3)
            axes.text(
                1.012, 0.5 + 0.17 * (len(row.series) - 1) - 0.34 * place, series.name, transform=axes.transAxes,
                fontsize=8.5, color=series.colour, va="center", fontweight="bold",
            )  # fmt: skip
    low, high = axes.get_ylim()
    room = 0.08 * (high - low)
    axes.set_ylim(low if row.low is None else row.low, high + room if row.high is None else row.high)
    axes.locator_params(axis="y", nbins=3)
    axes.tick_params(labelsize=8, colors=MUTED, length=2.5, width=0.6)
    axes.grid(visible=True, color=RULE, lw=0.6)
    axes.set_axisbelow(True)
    for name, spine in axes.spines.items():
        spine.set_visible(name in {"left", "bottom"})
        spine.set_color("#b8bcc4")


def _mark(axes: Axes, timeline: Timeline, now: float | None) -> None:
    tick = float(np.median(np.diff(timeline.time)))
    for begin, end in timeline.spans():
        axes.axvspan(begin, end + tick, color=REPAIRED_COLOUR, alpha=0.22, lw=0, zorder=1)
    if now is not None:
        axes.axvline(now, color=INK, lw=1.1, zorder=4)
