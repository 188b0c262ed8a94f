"""Contacts between vehicles of a film: who touched whom, when, where on the map and on which part of each."""

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from roadmend.core.geometry import corner_distance, fill_outline, wrap_angle
from roadmend.core.tick import INTERVAL
from roadmend.safe.film import Film
from roadmend.world.participants import Pose

_CORNER = 0.7  # share of a side's half length beyond which a contact on it is one of the corner
_SKIN = 0.06  # [m] by which outlines are grown to see the face that they share
_HALVINGS = 10  # of the tick in which two come to touch


class Part(StrEnum):
    """Part of a vehicle's outline, counter-clockwise from the front as seen from above."""

    FRONT = "front"
    FRONT_LEFT = "front-left"
    LEFT = "left"
    REAR_LEFT = "rear-left"
    REAR = "rear"
    REAR_RIGHT = "rear-right"
    RIGHT = "right"
    FRONT_RIGHT = "front-right"

    def is_near(self, other: "Part") -> bool:
        """Whether the two are the same part or one next to the other."""
        parts = [*Part]
        apart = abs(parts.index(self) - parts.index(other))
        return min(apart, len(parts) - apart) <= 1


@dataclass(frozen=True, slots=True)
class Touch:
    """What one of the two brings to a contact.

    Attributes:
        name: of the vehicle.
        part: that is touched.
        pose: at the contact.
        speed: along its own axis [m/s], negative where it moves backwards.
        approach: at which its own motion carries it towards the place of the contact [m/s].
    """

    name: str
    part: Part
    pose: Pose
    speed: float
    approach: float


@dataclass(frozen=True, slots=True)
class Contact:
    """Two vehicles come to touch.

    Attributes:
        tick: the first one at which their outlines overlap.
        x: of the place [m].
        y: of the place [m].
        one: the vehicle that comes first in the film.
        other: the second one.
    """

    tick: int
    x: float
    y: float
    one: Touch
    other: Touch

    @property
    def names(self) -> frozenset[str]:
        """The two."""
        return frozenset({self.one.name, self.other.name})

    def of(self, name: str) -> Touch:
        """One of the two, by name."""
        return self.one if self.one.name == name else self.other


def find_contacts(film: Film) -> list[Contact]:
    """Every pair's first contact, in the order in which they happen."""
    found: dict[frozenset[str], Contact] = {}
    before: Mapping[str, Pose] = {}
    for tick in range(len(film.ego)):
        now = film.poses(tick)
        for one, other in itertools.combinations(sorted(now, key=film.names.index), 2):
            pair = frozenset({one, other})
            if pair not in found and not pair <= film.fixed and _gap(now[one], now[other]) <= 0.0:
                # Within one tick the earlier touch is the first of the two; pairs are few, so the order of names does.
                found[pair] = _contact(tick, (one, other), before, now)
        before = now
    return list(found.values())


def _gap(one: Pose, other: Pose) -> float:
    """Distance of two outlines [m]; a lower bound of it where they are far apart."""
    apart = math.hypot(one.x - other.x, one.y - other.y)
    reach = 0.5 * (math.hypot(one.length, one.width) + math.hypot(other.length, other.width))
    if apart > reach:
        return apart - reach
    corners, their = np.empty((4, 2)), np.empty((4, 2))
    fill_outline(corners, one)
    fill_outline(their, other)
    return corner_distance(corners, their)


def _contact(tick: int, names: tuple[str, str], before: Mapping[str, Pose], now: Mapping[str, Pose]) -> Contact:
    one, other = names
    share = 1.0
    if one in before and other in before:
        low, high = 0.0, 1.0
        for _ in range(_HALVINGS):
            share = 0.5 * (low + high)
            if _gap(*(_between(before[name], now[name], share) for name in names)) > 0.0:
                low = share
            else:
                high = share
        share = high
    poses = [_between(before.get(name, now[name]), now[name], share) for name in names]
    x, y = _shared_place(*poses)
    touches = [
        _touch(name, pose, _velocity(before.get(name), now[name]), (x, y))
        for name, pose in zip(names, poses, strict=True)
    ]
    return Contact(tick, x, y, *touches)


def _velocity(begin: Pose | None, end: Pose) -> tuple[float, float]:
    """Over one tick [m/s], from the places: who is told to reverse need not say so in its speed."""
    if begin is None:
        return end.speed * math.cos(end.yaw), end.speed * math.sin(end.yaw)
    return (end.x - begin.x) / INTERVAL, (end.y - begin.y) / INTERVAL


def _touch(name: str, pose: Pose, velocity: tuple[float, float], place: tuple[float, float]) -> Touch:
    dx, dy = place[0] - pose.x, place[1] - pose.y
    apart = max(math.hypot(dx, dy), 1e-9)
    speed = velocity[0] * math.cos(pose.yaw) + velocity[1] * math.sin(pose.yaw)
    approach = (velocity[0] * dx + velocity[1] * dy) / apart
    return Touch(name, _part(pose, *place), pose, speed, approach)


def _between(begin: Pose, end: Pose, share: float) -> Pose:
    return Pose(
        begin.x + share * (end.x - begin.x),
        begin.y + share * (end.y - begin.y),
        wrap_angle(begin.yaw + share * wrap_angle(end.yaw - begin.yaw)),
        begin.speed + share * (end.speed - begin.speed),
        end.length,
        end.width,
    )


def _shared_place(one: Pose, other: Pose) -> tuple[float, float]:
    """The middle of what two outlines share that have just come to touch [m]."""
    import shapely  # noqa: PLC0415 - only a contact needs it

    shapes = []
    for pose in (one, other):
        corners = np.empty((4, 2))
        fill_outline(corners, Pose(pose.x, pose.y, pose.yaw, pose.speed, pose.length + _SKIN, pose.width + _SKIN))
        shapes.append(shapely.Polygon(corners))
    middle = shapely.intersection(*shapes).centroid
    if middle.is_empty:  # apart by a rounding error
        middle = shapely.shortest_line(*shapes).centroid
    return float(middle.x), float(middle.y)


def _part(pose: Pose, x: float, y: float) -> Part:
    """The part of an outline that a place on it belongs to."""
    dx, dy = x - pose.x, y - pose.y
    ahead = (math.cos(pose.yaw) * dx + math.sin(pose.yaw) * dy) / (0.5 * pose.length)
    left = (math.cos(pose.yaw) * dy - math.sin(pose.yaw) * dx) / (0.5 * pose.width)
    names = []
    if abs(ahead) >= abs(left) or abs(ahead) >= _CORNER:
        names.append("front" if ahead > 0.0 else "rear")
    if abs(left) > abs(ahead) or abs(left) >= _CORNER:
        names.append("left" if left > 0.0 else "right")
    return Part("-".join(names))
