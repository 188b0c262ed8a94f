"""The course of a whole episode as a strip: speed, distance, score, actions, states and events over time."""

import math
from dataclasses import dataclass
from typing import Self

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from roadmend.core.appearance import SILENT_COLOUR, STATUS_COLOUR, TRIGGER_COLOUR, status_of
from roadmend.core.outcome import Event, EventKind
from roadmend.core.repair import RepairStatus
from roadmend.core.spell_account import SpellAccount
from roadmend.measures.need_verdict import NeedVerdict, verdict_of
from roadmend.reports.scene_layers import REPAIRED_COLOUR

Floats = NDArray[np.float64]

INK, MUTED, RULE = "#22252b", "#5d636e", "#dddfe3"
SPEED_COLOUR = STATUS_COLOUR[RepairStatus.PASS]
POLICY_COLOUR = "#7b3fe4"
SCORE_COLOUR = "#0072b2"
VERDICT_COLOUR = {  # of an intervention; orange, as the state, where nobody has looked
    NeedVerdict.RESCUE: "#009e73",
    NeedVerdict.NUISANCE: "#d55e00",
    NeedVerdict.UNCLEAR: REPAIRED_COLOUR,
    None: REPAIRED_COLOUR,
}
SILENT = -1  # in place of a repair status where the repair node said nothing
LEFT, RIGHT = 0.085, 0.87  # share of the width at which the plots begin and end
GAP = 0.16  # of a row's height, between rows
BAND_HEIGHT = 0.42  # of the row of states; the names of events stand above
NAMES_MAX = 4  # states named beside their row
LETTER_SHARE = 0.0085  # of the width of the plots that a letter of an event's name takes


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
    status: NDArray[np.int64]  # of the repair node; SILENT where it said nothing
    events: tuple[Event, ...] = ()
    spells: tuple[SpellAccount, ...] = ()

    def spans(self) -> list[tuple[float, float]]:
        """First and last time [s] of each unbroken stretch of intervention."""
        edges = np.flatnonzero(np.diff(np.concatenate(([False], self.intervened, [False])).astype(np.int8)))
        return [
            (float(self.time[begin]), float(self.time[end - 1]))
            for begin, end in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)
        ]

    def bands(self) -> list["Band"]:
        """The unbroken stretches of one repair status."""
        begins = np.flatnonzero(np.diff(self.status, prepend=self.status[:1] - 1))
        ends = [*self.time[begins[1:]].tolist(), float(self.time[-1])]
        return [
            Band.of_status(float(self.time[begin]), end, int(self.status[begin]))
            for begin, end in zip(begins.tolist(), ends, strict=True)
        ]


@dataclass(frozen=True, slots=True)
class Band:
    """A stretch of time [s] with a name and a colour, and a label above it."""

    begin: float
    end: float
    name: str
    colour: str
    label: str = ""

    @classmethod
    def of_status(cls, begin: float, end: float, status: int) -> Self:
        """A stretch in which the repair node was in one state, or SILENT."""
        if status == SILENT:
            return cls(begin, end, "silent", SILENT_COLOUR)
        known = status_of(status)
        return cls(begin, end, known.name.lower().replace("_", " "), STATUS_COLOUR[known])

    @classmethod
    def of_spell(cls, number: int, account: SpellAccount) -> Self:
        """An intervention, with its number from 1 on as in the table, named by what it was."""
        verdict, spell = verdict_of(account.spell.need), account.spell
        return cls(spell.begin, spell.end, verdict or "intervention", VERDICT_COLOUR[verdict], f"{number}")


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
    series: tuple[Series, ...] = ()
    low: float | None = None  # limits of the axis; None: as the data have it
    high: float | None = None
    bands: tuple[Band, ...] = ()
    has_events: bool = False  # whether their names stand above the bands


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
    rows = [row for row in rows if any(np.isfinite(series.values).any() for series in row.series)]
    if (timeline.status != SILENT).any():
        rows.append(Row("state", bands=tuple(timeline.bands()), has_events=True))
    if timeline.spells:
        spells = tuple(Band.of_spell(number, account) for number, account in enumerate(timeline.spells, 1))
        rows.append(Row("spells", bands=spells))
    return rows


def draw_timeline(
    figure: Figure,
    timeline: Timeline,
    box: tuple[float, float, float, float] = (0.0, 0.0, 1.0, 1.0),
    now: float | None = None,
) -> list[Axes]:
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
        _draw_lines(axes, timeline, row)
        if row.bands:
            _draw_bands(axes, row)
            _draw_labels(axes, timeline, row)
        if row.has_events:
            _draw_events(axes, timeline)
        _finish(axes, row)
        _mark(axes, timeline, now)
        axes.tick_params(axis="x", labelbottom=index == len(rows) - 1)
        drawn.append(axes)
    if drawn:
        drawn[0].set_xlim(float(timeline.time[0]), float(timeline.time[-1]))
        drawn[-1].set_xlabel("simulation time [s]", fontsize=8.5, color=MUTED, labelpad=2)
    return drawn


def _draw_lines(axes: Axes, timeline: Timeline, row: Row) -> None:
    axes.set_ylabel(row.label, fontsize=8.5, color=INK, rotation=0, ha="right", va="center", labelpad=8)
    for place, series in enumerate(row.series):
        if np.isfinite(series.values).any():
            axes.plot(timeline.time, series.values, series.style, color=series.colour, lw=1.5, zorder=3)
            axes.text(
                1.012,
                0.5 + 0.17 * (len(row.series) - 1) - 0.34 * place,
                series.name,
                transform=axes.transAxes,
                fontsize=8.5,
                color=series.colour,
                va="center",
                fontweight="bold",
            )


def _draw_bands(axes: Axes, row: Row) -> None:
    length: dict[tuple[str, str], float] = {}  # [s] by name and colour
    for band in row.bands:
        axes.broken_barh([(band.begin, band.end - band.begin)], (0.0, BAND_HEIGHT), color=band.colour, lw=0, zorder=3)
        kind = band.name, band.colour
        length[kind] = length.get(kind, 0.0) + band.end - band.begin
    named = sorted(length, key=lambda kind: -length[kind])[:NAMES_MAX]
    for place, (name, colour) in enumerate(named):
        axes.text(
            1.012,
            0.5 + 0.13 * (len(named) - 1) - 0.26 * place,
            name,
            transform=axes.transAxes,
            fontsize=8 if len(named) > 2 else 8.5,
            color=colour,
            va="center",
            fontweight="bold",
        )
    axes.set_ylim(0.0, 1.0)
    axes.set_yticks([])


def _draw_labels(axes: Axes, timeline: Timeline, row: Row) -> None:
    """The label of each band above its middle, where there is room for it."""
    room = 2.0 * LETTER_SHARE * float(timeline.time[-1] - timeline.time[0])  # [s]
    taken = -math.inf
    for band in row.bands:
        middle = 0.5 * (band.begin + band.end)
        if band.label and middle - taken > room:
            axes.text(middle, BAND_HEIGHT + 0.08, band.label, fontsize=7.5, color=band.colour, ha="center", va="bottom")
            taken = middle


def _draw_events(axes: Axes, timeline: Timeline) -> None:
    """A dotted line at each event; its name where there is room for it on one of two lines."""
    first, last = float(timeline.time[0]), float(timeline.time[-1])
    taken: list[list[tuple[float, float]]] = [[], []]  # [s] by line
    for event in timeline.events:
        if event.kind is EventKind.STARTED:
            continue
        axes.axvline(event.time, color=INK, lw=0.8, ls=":", zorder=4)
        name = event.kind.name.lower().replace("_", " ")
        length = LETTER_SHARE * (len(name) + 1) * (last - first)
        to_right = event.time + length < last
        begin, end = (event.time, event.time + length) if to_right else (event.time - length, event.time)
        for level, others in enumerate(taken):
            if all(end <= other[0] or begin >= other[1] for other in others):
                others.append((begin, end))
                axes.annotate(
                    name,
                    (event.time, 0.98 - 0.25 * level),
                    fontsize=7.5,
                    color=INK,
                    va="top",
                    zorder=5,
                    xytext=(2 if to_right else -2, 0),
                    textcoords="offset points",
                    ha="left" if to_right else "right",
                )
                break


def _finish(axes: Axes, row: Row) -> None:
    if row.series:
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
    verdicts = {account.spell.begin: verdict_of(account.spell.need) for account in timeline.spells}
    for begin, end in timeline.spans():
        colour = VERDICT_COLOUR[verdicts.get(begin)]
        axes.axvspan(begin, end + tick, color=colour, alpha=0.22, lw=0, zorder=1)
    if now is not None:
        axes.axvline(now, color=INK, lw=1.1, zorder=4)
