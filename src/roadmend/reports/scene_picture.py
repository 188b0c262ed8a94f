"""A tick of an episode as a picture from above, with the time line of the whole episode under it."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from roadmend.core.appearance import (
    KIND_COLOUR,
    PLAN_COLOUR,
    SILENT_COLOUR,
    STATUS_COLOUR,
    TRIGGER_COLOUR,
    kind_of,
)
from roadmend.core.command import Trajectory
from roadmend.core.repair import Repair
from roadmend.core.route import Route
from roadmend.core.scene import EgoState, ObjectList
from roadmend.reports import scene_layers
from roadmend.reports.scene_layers import INK, MUTED, Canvas, Trail
from roadmend.reports.scene_timeline import Timeline, draw_timeline, rows_of
from roadmend.world.road_network import LaneMap

Floats = NDArray[np.float64]

WIDTH = 10.0  # [inch] of the whole picture
SCENE_HEIGHT = 5.6  # [inch]
HEAD_HEIGHT = 0.95  # [inch] for the caption above
LEGEND_HEIGHT = 0.42  # [inch] under the scene
ROW_HEIGHT = 0.92  # [inch] of each row of the time line
FOOT_HEIGHT = 0.55  # [inch] for the time axis
MARGIN = 0.3  # [inch]
AHEAD = 0.12  # how far the picture is shifted ahead of the ego, as a share of its width


@dataclass(frozen=True, slots=True, eq=False)
class SceneView:
    """What one picture shows; whatever is None or empty is left out."""

    scenario: str
    time: float  # [s]
    ego: EgoState
    objects: ObjectList
    lanes: LaneMap | None = None
    route: Route | None = None
    trajectory: Trajectory | None = None
    repair: Repair | None = None
    trail: Trail | None = None  # where the ego has been until now
    timeline: Timeline | None = None  # the whole episode
    outcome: str = ""  # how the episode ended, in a word or two
    mark: tuple[float, float] | None = None  # a place to look at [m], where two came to touch


@mpl.rc_context({"text.parse_math": False})  # names and reasons come from outside: a dollar is a dollar
def draw_scene(view: SceneView, span: float = 70.0) -> Figure:
    """Draw one tick.

    Args:
        view: what to show, frame map; east is right and north is up.
        span: width of the crop around the ego [m].

    Raises:
        ValueError: ``span`` is not positive, or the ego's pose is not finite.
    """
    if not span > 0.0:
        raise ValueError(f"span {span:g} must be above zero")
    if not all(math.isfinite(value) for value in (view.ego.x, view.ego.y, view.ego.yaw)):
        raise ValueError("the pose of the ego is not finite")
    rows = 0 if view.timeline is None else len(rows_of(view.timeline))
    strip = rows * ROW_HEIGHT + FOOT_HEIGHT if rows else 0.0
    height = HEAD_HEIGHT + SCENE_HEIGHT + LEGEND_HEIGHT + strip + 0.5 * MARGIN
    figure = Figure(figsize=(WIDTH, height), facecolor="white")
    inner = WIDTH - 2.0 * MARGIN
    bottom = height - HEAD_HEIGHT - SCENE_HEIGHT
    axes = figure.add_axes((MARGIN / WIDTH, bottom / height, inner / WIDTH, SCENE_HEIGHT / height))
    _frame(axes, view.ego, span, span * SCENE_HEIGHT / inner)
    canvas = Canvas(axes, points_per_metre=inner * 72.0 / span)
    _paint(canvas, view)
    scene_layers.draw_scale_bar(canvas)
    _caption(figure, view, height)
    _legend(axes, view)
    if view.timeline is not None and rows:
        draw_timeline(figure, view.timeline, box=(0.0, 0.5 * MARGIN / height, 1.0, strip / height), now=view.time)
    return figure


def _frame(axes: Axes, ego: EgoState, width: float, height: float) -> None:
    x, y = ego.x + AHEAD * width * math.cos(ego.yaw), ego.y + AHEAD * height * math.sin(ego.yaw)
    axes.set_xlim(x - 0.5 * width, x + 0.5 * width)
    axes.set_ylim(y - 0.5 * height, y + 0.5 * height)
    axes.set_aspect("equal")
    axes.set_xticks([])
    axes.set_yticks([])
    axes.set_facecolor(scene_layers.LAND)
    for spine in axes.spines.values():
        spine.set_color("#c9c9c4")


def _paint(canvas: Canvas, view: SceneView) -> None:
    if view.lanes is not None:
        scene_layers.draw_lanes(canvas, view.lanes)
    if view.route is not None:
        scene_layers.draw_route(canvas, view.route)
    if view.trail is not None:
        scene_layers.draw_trail(canvas, view.trail)
    triggers = () if view.repair is None else tuple(trigger.object_id for trigger in view.repair.triggers)
    scene_layers.draw_objects(canvas, view.objects, triggers)
    if view.trajectory is not None:
        scene_layers.draw_plan(canvas, view.trajectory, view.ego)
    scene_layers.draw_ego(canvas, view.ego, _ego_colour(view))
    if view.mark is not None:
        canvas.axes.plot(*view.mark, marker="*", markersize=16, color="white", markeredgecolor=INK, zorder=20)


def _caption(figure: Figure, view: SceneView, height: float) -> None:
    write: Callable[..., Any] = figure.text
    left, right = MARGIN / WIDTH, 1.0 - MARGIN / WIDTH
    first, second, third = (1.0 - depth / height for depth in (0.3, 0.56, 0.8))
    write(left, first, view.scenario, fontsize=14, fontweight="bold", color=INK, va="center")
    clock = f"t = {view.time:.2f} s"
    if view.outcome:
        clock = f"{view.outcome}  ·  {clock}"
    write(right, first, clock, fontsize=12, color=INK, ha="right", va="center")
    facts = [f"{view.ego.speed:.1f} m/s ({3.6 * view.ego.speed:.0f} km/h)"]
    repair = view.repair
    if repair is not None:
        if math.isfinite(repair.score):
            facts.append(f"score {repair.score:.2f}")
        if math.isfinite(repair.threshold):
            facts.append(f"threshold {repair.threshold:.2f}")
        if repair.intervened:
            facts.append(f"asked {_signed(repair.policy_action)} → sent {_signed(repair.final_action)}")
        else:
            facts.append(f"command {_signed(repair.final_action)}")
        pill = {"boxstyle": "round,pad=0.35,rounding_size=0.5", "fc": STATUS_COLOUR[repair.status], "ec": "none"}
        name = repair.status.name.replace("_", " ")
        write(
            right - 0.006,
            second,
            name,
            fontsize=9,
            fontweight="bold",
            color="white",
            ha="right",
            va="center",
            bbox=pill,
        )
    write(left, second, "   ·   ".join(facts), fontsize=10.5, color=INK, va="center")
    reason = "" if repair is None else repair.reason
    write(left, third, reason, fontsize=9.5, color=MUTED, style="italic", va="center")


def _legend(axes: Axes, view: SceneView) -> None:
    handles: list[Patch | Line2D] = [Patch(fc=_ego_colour(view), ec=INK, lw=1.4, label="ego")]
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    x, y = view.objects.x, view.objects.y
    inside = (x > left) & (x < right) & (y > low) & (y < high)
    seen = {kind_of(int(code)) for code in view.objects.kind[inside]}
    handles += [Patch(fc=KIND_COLOUR[kind], ec=INK, lw=0.5, label=kind.name.lower()) for kind in sorted(seen)]
    if view.repair is not None and view.repair.triggers:
        handles.append(Patch(fc="none", ec=TRIGGER_COLOUR, lw=2.2, label="trigger"))
    if view.trajectory is not None and len(view.trajectory):
        handles.append(Line2D([], [], color=PLAN_COLOUR, lw=1.6, marker="o", ms=3.5, label="policy's plan"))
    if view.trail is not None and len(view.trail.x) > 1:
        handles.append(Line2D([], [], color=scene_layers.TRAIL_COLOUR, lw=2.0, label="driven"))
        if view.trail.intervened.any():
            handles.append(Line2D([], [], color=scene_layers.REPAIRED_COLOUR, lw=2.0, label="driven, repaired"))
    axes.legend(
        handles=handles,
        loc="upper left",
        bbox_to_anchor=(-0.004, 0.0),
        ncols=len(handles),
        frameon=False,
        fontsize=8.5,
        handlelength=1.5,
        columnspacing=1.3,
        handletextpad=0.5,
        borderaxespad=0.25,
        labelcolor=INK,
    )


def _ego_colour(view: SceneView) -> str:
    return SILENT_COLOUR if view.repair is None else STATUS_COLOUR[view.repair.status]


def _signed(action: float) -> str:
    return f"{action:+.2f}".replace("-", "\N{MINUS SIGN}") if math.isfinite(action) else "none"
