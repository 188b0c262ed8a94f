"""The layers of a picture from above, from the ground up: lanes, route, trail, participants, plan, ego."""

import math
from dataclasses import dataclass

import numpy as np
from matplotlib import patheffects
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import to_rgb
from numpy.typing import NDArray

from roadmend.core.appearance import (
    GOAL_COLOUR,
    KIND_COLOUR,
    PLAN_COLOUR,
    ROUTE_COLOUR,
    RULE_COLOUR,
    STATUS_COLOUR,
    TRIGGER_COLOUR,
    kind_of,
)
from roadmend.core.command import Trajectory
from roadmend.core.geometry import fill_corners
from roadmend.core.repair import RepairStatus
from roadmend.core.route import Route
from roadmend.core.scene import EgoState, ObjectKind, ObjectList
from roadmend.world.road_network import LaneKind, LaneMap

Floats = NDArray[np.float64]

INK, MUTED = "#22252b", "#5d636e"
LAND, KERB, ASPHALT, PAINT = "#f3f2ec", "#a3a9b2", "#d5d8dd", "#ffffff"
PAVING, PAVING_EDGE = "#e6dfcf", "#cdc4ae"
TRAIL_COLOUR, REPAIRED_COLOUR = "#2f6f5e", STATUS_COLOUR[RepairStatus.REPAIRED]
LANE_LINE = 0.16  # [m]
KERB_WIDTH = 0.35  # [m]
SEAM = 0.3  # [m] by which junctions reach over the lanes that end there, or a pale line stays between them
BAR_HALF = 1.6  # [m] half length of stop and goal lines


@dataclass(frozen=True, slots=True, eq=False)
class Trail:
    """Where the ego has been, oldest first, shape (T,) each."""

    x: Floats  # [m]
    y: Floats  # [m]
    intervened: NDArray[np.bool_]  # whether the method drove there


@dataclass(frozen=True, slots=True)
class Canvas:
    """Axes in metres whose scale is known, so that a line can be as wide as a lane."""

    axes: Axes
    points_per_metre: float

    def strokes(self, lines: list[Floats], widths: Floats | float, colour: str, z: float, *, cap: str = "butt") -> None:
        """Lines (shape (p, 2) each) of the given widths [m]."""
        if lines:
            thick = np.broadcast_to(np.asarray(widths, dtype=np.float64) * self.points_per_metre, len(lines))
            self.axes.add_collection(
                LineCollection(lines, linewidths=thick, colors=colour, zorder=z, capstyle=cap, joinstyle="round"),
                autolim=False,
            )

    def shapes(self, corners: list[Floats], colours: list[str], edge: str, line: float, z: float) -> None:
        """Filled polygons (shape (p, 2) each), ``line`` points wide at the edge."""
        if corners:
            self.axes.add_collection(
                PolyCollection(
                    corners, facecolors=colours, edgecolors=edge, linewidths=line, zorder=z, joinstyle="round"
                ),
                autolim=False,
            )


def draw_lanes(canvas: Canvas, lanes: LaneMap) -> None:
    """Kerbs under lane lines under asphalt: neighbouring lanes grow together and keep a line between them."""
    walks, walk_widths = lanes.lines(LaneKind.WALK)
    roads, road_widths = lanes.lines(LaneKind.ROAD)
    inner, inner_widths = lanes.lines(LaneKind.JUNCTION)
    canvas.strokes(walks, walk_widths + 0.2, PAVING_EDGE, 1.0)
    canvas.strokes(walks, walk_widths, PAVING, 1.1)
    canvas.strokes(roads, road_widths + 2.0 * KERB_WIDTH, KERB, 1.2)
    canvas.strokes(inner, inner_widths + 2.0 * KERB_WIDTH, KERB, 1.2)
    canvas.strokes(roads, road_widths + LANE_LINE, PAINT, 1.3)
    canvas.strokes(roads, road_widths - LANE_LINE, ASPHALT, 1.4)
    canvas.strokes([_lengthened(line, SEAM) for line in inner], inner_widths + LANE_LINE, ASPHALT, 1.5)


def draw_route(canvas: Canvas, route: Route) -> None:
    """The route's lanes tinted, stop lines in the colour of their rule, and the goal."""
    canvas.strokes([np.column_stack((stage.x, stage.y)) for stage in route.stages], 0.5, _pale(ROUTE_COLOUR, 0.35), 2.0)
    for zone in route.zones:
        bar = _bar(*route.stages[zone.stage].pose(zone.begin))
        canvas.strokes([bar], 0.5, RULE_COLOUR[zone.rule], 2.1)
    if route.stages:
        goal = _bar(*route.stages[-1].pose(route.goal))
        canvas.strokes([goal], 0.9, PAINT, 2.2)
        canvas.strokes([goal], 0.6, GOAL_COLOUR, 2.3)
        canvas.axes.annotate(
            "goal",
            goal.mean(axis=0),
            xytext=(0, 12),
            textcoords="offset points",
            fontsize=9,
            fontweight="bold",
            color=GOAL_COLOUR,
            ha="center",
            zorder=9.0,
            annotation_clip=True,
            path_effects=_halo(),
        )


def draw_trail(canvas: Canvas, trail: Trail) -> None:
    """The way driven so far, paler with age, in another colour where the method drove."""
    points = np.column_stack((trail.x, trail.y))
    if len(points) < 2:
        return
    segments = np.stack((points[:-1], points[1:]), axis=1)
    age = np.linspace(0.3, 1.0, len(segments))[:, None]
    driver = np.where(trail.intervened[1:, None], to_rgb(REPAIRED_COLOUR), to_rgb(TRAIL_COLOUR))
    # Mixed with the ground instead of transparent: overlapping ends would show as dots.
    colours = age * driver + (1.0 - age) * np.array(to_rgb(ASPHALT))
    canvas.axes.add_collection(
        LineCollection(list(segments), colors=colours, linewidths=2.2, zorder=3.0, capstyle="round"), autolim=False
    )


def draw_objects(canvas: Canvas, objects: ObjectList, triggers: tuple[int, ...]) -> None:
    """Outlines by kind with a pale tip at the front; those that triggered get a frame and their number."""
    bodies: list[Floats] = []
    tips: list[Floats] = []
    colours: list[str] = []
    for index in range(len(objects)):
        numbers = (objects.x, objects.y, objects.yaw, objects.length, objects.width)
        x, y, yaw, length, width = (float(column[index]) for column in numbers)
        if not all(math.isfinite(value) for value in (x, y, yaw, length, width)):
            continue
        kind = kind_of(int(objects.kind[index]))
        bodies.append(outline_of(x, y, yaw, length, width))
        colours.append(KIND_COLOUR[kind])
        if kind is ObjectKind.PEDESTRIAN:
            halo = outline_of(x, y, yaw, length + 0.5, width + 0.5)
            canvas.shapes([halo], [_pale(KIND_COLOUR[kind], 0.6)], INK, 0.6, 4.0)
        else:
            tips.append(_tip(x, y, yaw, length, width))
        if int(objects.id[index]) in triggers:
            _draw_trigger(canvas, outline_of(x, y, yaw, length + 0.9, width + 0.9), int(objects.id[index]))
    canvas.shapes(bodies, colours, INK, 0.7, 4.1)
    canvas.shapes(tips, ["#ffffffb0"] * len(tips), "none", 0.0, 4.2)


def _draw_trigger(canvas: Canvas, frame: Floats, identity: int) -> None:
    canvas.shapes([frame], [_pale(TRIGGER_COLOUR, 0.2)], TRIGGER_COLOUR, 2.4, 4.05)
    top = frame[np.argmax(frame[:, 1])]
    canvas.axes.annotate(
        f"trigger {identity}",
        (float(frame[:, 0].mean()), float(top[1])),
        xytext=(0, 5),
        textcoords="offset points",
        fontsize=9,
        fontweight="bold",
        color=TRIGGER_COLOUR,
        ha="center",
        zorder=9.0,
        annotation_clip=True,
        path_effects=_halo(),
    )


def draw_plan(canvas: Canvas, trajectory: Trajectory, ego: EgoState) -> None:
    """The planned trajectory from the ego on, a dot at each of its points."""
    points = np.column_stack((trajectory.x, trajectory.y))
    points = points[np.isfinite(points).all(axis=1)]
    if len(points):
        line = np.vstack(((ego.x, ego.y), points))
        draw = canvas.axes.plot
        draw(line[:, 0], line[:, 1], color=PAINT, lw=3.6, zorder=5.0, alpha=0.8, scalex=False, scaley=False)
        draw(line[:, 0], line[:, 1], color=PLAN_COLOUR, lw=1.7, zorder=5.1, scalex=False, scaley=False)
        draw(
            points[:, 0],
            points[:, 1],
            "o",
            color=PLAN_COLOUR,
            ms=4.0,
            mec=PAINT,
            mew=0.7,
            zorder=5.2,
            scalex=False,
            scaley=False,
        )


def draw_ego(canvas: Canvas, ego: EgoState, colour: str) -> None:
    """The ego on top of all, in the colour of the repair status, with a dark frame."""
    around = outline_of(ego.x, ego.y, ego.yaw, ego.length + 0.5, ego.width + 0.5)
    canvas.shapes([around], [PAINT], "none", 0.0, 6.0)
    canvas.shapes([outline_of(ego.x, ego.y, ego.yaw, ego.length, ego.width)], [colour], INK, 1.8, 6.1)
    canvas.shapes([_tip(ego.x, ego.y, ego.yaw, ego.length, ego.width)], [INK], "none", 0.0, 6.2)


def draw_scale_bar(canvas: Canvas, length: float = 10.0) -> None:
    """A bar of ``length`` [m] in the lower left corner, with the direction of north."""
    (left, _), (low, high) = canvas.axes.get_xlim(), canvas.axes.get_ylim()
    unit = (high - low) / 100.0
    x, y = left + 3.0 * unit, low + 4.0 * unit
    bar = np.array([[x, y + unit], [x, y], [x + length, y], [x + length, y + unit]])
    for width, colour, z in ((4.0, PAINT, 8.0), (1.6, INK, 8.1)):
        canvas.axes.plot(bar[:, 0], bar[:, 1], color=colour, lw=width, zorder=z, scalex=False, scaley=False)
    canvas.axes.text(
        x + 0.5 * length,
        y + 1.6 * unit,
        f"{length:g} m",
        fontsize=9,
        color=INK,
        ha="center",
        va="bottom",
        zorder=8.2,
        path_effects=_halo(),
    )


def outline_of(x: float, y: float, yaw: float, length: float, width: float) -> Floats:
    """Corners of an outline, shape (4, 2), counter-clockwise from front left."""
    corners = np.empty((4, 2), dtype=np.float64)
    fill_corners(corners, x, y, yaw, length, width)
    return corners


def _lengthened(line: Floats, by: float) -> Floats:
    first, last = line[0] - line[1], line[-1] - line[-2]
    first, last = (step / max(float(np.hypot(*step)), 1e-9) for step in (first, last))
    return np.vstack((line[0] + by * first, line, line[-1] + by * last))


def _tip(x: float, y: float, yaw: float, length: float, width: float) -> Floats:
    front, back = 0.46 * length, 0.46 * length - min(0.75 * width, 0.4 * length)
    along, across = np.array([front, back, back]), np.array([0.0, 0.4 * width, -0.4 * width])
    cosine, sine = math.cos(yaw), math.sin(yaw)
    return np.column_stack((x + along * cosine - across * sine, y + along * sine + across * cosine))


def _bar(x: float, y: float, yaw: float) -> Floats:
    offset = BAR_HALF * np.array([1.0, -1.0])
    return np.column_stack((x - offset * math.sin(yaw), y + offset * math.cos(yaw)))


def _pale(colour: str, share: float) -> str:
    mixed = (round(255 * (share * part + 1.0 - share)) for part in to_rgb(colour))
    return "#" + "".join(f"{part:02x}" for part in mixed)


def _halo() -> list[patheffects.AbstractPathEffect]:
    return [patheffects.withStroke(linewidth=2.6, foreground=PAINT)]
