"""What a learner sees: the ego, its road, the conflict zones and the participants, as arrays of fixed size.

Numbers are in SI units, in the ego's own frame (base_link: x ahead, y to the left, headings counter-clockwise from its
own). Each column has its bounds, and what lies beyond them is set to the bound. What is missing is zero, and its mask
says so.
"""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from roadmend.core.geometry import wrap_angle
from roadmend.core.route import RightOfWay, Route
from roadmend.core.scene import ObjectKind, Scene, Signal
from roadmend.core.tick import INTERVAL
from roadmend.measures.route_progress import RoutePlace

Floats = NDArray[np.float32]
Observation = dict[str, NDArray[np.generic]]

AHEAD = (5.0, 10.0, 20.0, 30.0, 45.0, 60.0)  # [m] along the lane at which the road is described
ZONES = 3  # the next ones of the lane
_FAR = 500.0  # [m]


class Field(NamedTuple):
    """One number of an observation."""

    name: str
    unit: str  # empty where it has none
    low: float
    high: float
    meaning: str


def _one_hot(kinds: type[ObjectKind | RightOfWay | Signal], of: str) -> tuple[Field, ...]:
    return tuple(Field(kind.name.lower(), "", 0.0, 1.0, f"1 where {of} is {kind.name.lower()}") for kind in kinds)


EGO = (
    Field("speed", "m/s", 0.0, 80.0, "speed"),
    Field("acceleration", "m/s2", -15.0, 15.0, "acceleration over the last tick"),
    Field("yaw_rate", "rad/s", -3.0, 3.0, "yaw rate"),
    Field("offset", "m", -10.0, 10.0, "from the lane's centre line, left positive"),
    Field("speed_limit", "m/s", 0.0, 80.0, "speed limit of the lane here"),
    Field("left", "m", 0.0, 10_000.0, "way that is left to the goal"),
    Field("time_left", "s", 0.0, 86_400.0, "time that is left"),
    Field("must_change", "", 0.0, 1.0, "1 where the route changes to another lane from here"),
    Field("change_begin", "m", -_FAR, _FAR, "to where the lane change may begin, negative behind"),
    Field("change_end", "m", -_FAR, _FAR, "to where it must have begun"),
    Field("change_side", "", -1.0, 1.0, "1 where that lane is to the left, -1 to the right, 0 where there is none"),
)
ROAD = (
    Field("x", "m", -100.0, 100.0, "point of the lane's centre line"),
    Field("y", "m", -100.0, 100.0, "the same"),
    Field("yaw", "rad", -math.pi, math.pi, "heading of the lane there"),
    Field("speed_limit", "m/s", 0.0, 80.0, "speed limit there"),
)
ZONE = (
    Field("begin", "m", -_FAR, _FAR, "from the ego's front to the stop line"),
    Field("end", "m", -_FAR, _FAR, "from the ego's rear to where the zone is left"),
    *_one_hot(RightOfWay, "the rule"),
    *_one_hot(Signal, "the traffic light"),
)
OBJECT = (
    Field("x", "m", -_FAR, _FAR, "centre of the outline"),
    Field("y", "m", -_FAR, _FAR, "the same"),
    Field("yaw", "rad", -math.pi, math.pi, "heading"),
    Field("speed", "m/s", -80.0, 80.0, "speed along its heading, over ground"),
    Field("acceleration", "m/s2", -15.0, 15.0, "along its heading"),
    Field("yaw_rate", "rad/s", -3.0, 3.0, "yaw rate"),
    Field("length", "m", 0.0, 50.0, "of the outline"),
    Field("width", "m", 0.0, 10.0, "of the outline"),
    *_one_hot(ObjectKind, "its kind"),
)


def observation_space(most: int) -> spaces.Space[Observation]:
    """The space of ``observe`` for at most ``most`` participants: a ``gymnasium.spaces.Dict``."""
    space: Any = spaces.Dict(
        {
            "ego": _box((), EGO),
            "road": _box((len(AHEAD),), ROAD),
            "zones": _box((ZONES,), ZONE),
            "zones_mask": spaces.MultiBinary(ZONES),
            "objects": _box((most,), OBJECT),
            "objects_mask": spaces.MultiBinary(most),
        }
    )
    return space  # type: ignore[no-any-return] # Gymnasium's own type for it does not know its keys


def observe(
    scene: Scene, route: Route, place: RoutePlace, way_left: float, speed_before: float, most: int
) -> Observation:
    """A scene as arrays.

    Args:
        scene: what there is to see.
        route: the ego's.
        place: where the ego is on it.
        way_left: to the goal [m].
        speed_before: of the ego at the last tick [m/s].
        most: participants; of more, the nearest.
    """
    zones, zones_mask = _zones(scene, route, place)
    objects, objects_mask = _objects(scene, most)
    return {
        "ego": _bounded(_ego(scene, route, place, way_left, speed_before), EGO),
        "road": _bounded(_road(scene, route, place), ROAD),
        "zones": _bounded(zones, ZONE),
        "zones_mask": zones_mask,
        "objects": _bounded(objects, OBJECT),
        "objects_mask": objects_mask,
    }


def _ego(scene: Scene, route: Route, place: RoutePlace, way_left: float, speed_before: float) -> NDArray[np.float64]:
    ego, stage = scene.ego, route.stages[place.stage]
    change = [0.0, 0.0, 0.0, 0.0]
    if place.stage < len(route.windows):
        window = route.windows[place.stage]
        after = route.stages[place.stage + 1]
        # Told where the change may begin: from further away the next lane may lie around a corner.
        x, y, _ = stage.pose(max(place.position, window.begin))
        _, aside = after.project(x, y, 0.5 * after.length, after.length)
        change = [1.0, window.begin - place.position, window.end - place.position, -math.copysign(1.0, aside)]
    return np.array(
        [
            ego.speed,
            (ego.speed - speed_before) / INTERVAL,
            ego.yaw_rate,
            place.offset,
            stage.limit_at(place.position),
            way_left,
            route.time_limit - scene.time,
            *change,
        ]
    )


def _road(scene: Scene, route: Route, place: RoutePlace) -> NDArray[np.float64]:
    ego, stage = scene.ego, route.stages[place.stage]
    rows = np.zeros((len(AHEAD), len(ROAD)))
    for row, ahead in zip(rows, AHEAD, strict=True):
        x, y, yaw = stage.pose(place.position + ahead)
        row[:2] = _in_frame(x - ego.x, y - ego.y, ego.yaw)
        row[2:] = wrap_angle(yaw - ego.yaw), stage.limit_at(place.position + ahead)
    return rows


def _zones(scene: Scene, route: Route, place: RoutePlace) -> tuple[NDArray[np.float64], NDArray[np.int8]]:
    half = 0.5 * scene.ego.length
    rows, mask = np.zeros((ZONES, len(ZONE))), np.zeros(ZONES, dtype=np.int8)
    ahead = [zone for zone in route.zones if zone.stage == place.stage and zone.end - place.position > -half]
    for number, zone in enumerate(sorted(ahead, key=lambda each: each.begin)[:ZONES]):
        row, mask[number] = rows[number], 1
        row[:2] = place.ahead(zone) - half, zone.end - place.position + half
        row[2 + int(zone.rule)] = 1.0
        if 0 <= zone.signal < len(scene.signals):
            row[2 + len(RightOfWay) + int(scene.signals[zone.signal])] = 1.0
    return rows, mask


def _objects(scene: Scene, most: int) -> tuple[NDArray[np.float64], NDArray[np.int8]]:
    ego, others = scene.ego, scene.objects
    rows, mask = np.zeros((most, len(OBJECT))), np.zeros(most, dtype=np.int8)
    dx, dy = others.x - ego.x, others.y - ego.y
    nearest = np.argsort(dx * dx + dy * dy, kind="stable")[:most]
    count = len(nearest)
    mask[:count] = 1
    rows[:count, 0], rows[:count, 1] = _in_frame(dx[nearest], dy[nearest], ego.yaw)
    turn = others.yaw[nearest] - ego.yaw
    rows[:count, 2] = turn - 2.0 * math.pi * np.round(turn / (2.0 * math.pi))
    for place, name in enumerate(("speed", "acceleration", "yaw_rate", "length", "width"), 3):
        rows[:count, place] = others.table[name][nearest]
    rows[np.arange(count), 8 + others.kind[nearest].astype(np.intp)] = 1.0
    return rows, mask


def _in_frame(dx: Any, dy: Any, yaw: float) -> tuple[Any, Any]:
    cosine, sine = math.cos(yaw), math.sin(yaw)
    return dx * cosine + dy * sine, dy * cosine - dx * sine


def _box(shape: tuple[int, ...], columns: Sequence[Field]) -> spaces.Box:
    low, high = _bounds(columns)
    whole = (*shape, len(columns))
    return spaces.Box(np.broadcast_to(low, whole), np.broadcast_to(high, whole), dtype=np.float32)


def _bounded(rows: NDArray[np.float64], columns: Sequence[Field]) -> Floats:
    low, high = _bounds(columns)
    return np.clip(rows.astype(np.float32), low, high)


def _bounds(columns: Sequence[Field]) -> tuple[Floats, Floats]:
    low = np.array([column.low for column in columns], dtype=np.float32)
    high = np.array([column.high for column in columns], dtype=np.float32)
    return low, high
