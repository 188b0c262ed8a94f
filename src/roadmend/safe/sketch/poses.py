"""How the vehicles of a sketch stand, and from which of its poses each one comes.

A sketch shows a vehicle several times: on its approach, at the contact, at rest. Where it comes from is the pose, and
the end of it, that what is drawn speaks for: the triangle at the front, an arrow that leaves it, the other poses and
the contact ahead of it.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from roadmend.safe.sketch.arrows import DrawnArrow
from roadmend.safe.sketch.outlines import Outline

_TRIANGLE = 3.0  # what each sign weighs
_ARROW = 1.5
_POSES_AHEAD = 1.0
_CONTACT_AHEAD = 1.0
_FAR = 0.8
_SPACED = 0.5
_CONE = 30.0  # [deg] to either side, within which something is ahead
_ARROW_CONE = 25.0  # [deg]
_TOUCHING = 0.35  # [vehicle widths] between two vehicles in contact at most


@dataclass(frozen=True, slots=True)
class VehiclePose:
    """A vehicle as it is drawn once.

    Attributes:
        outline: around it.
        number: of the vehicle; None where it is not known.
        confidence: of the number, from 0 to 1.
        front: 1 where the outline's axis leads to the front, -1 where to the rear, 0 where that is not seen.
    """

    outline: Outline
    number: int | None
    confidence: float
    front: int

    @property
    def heading(self) -> float | None:
        """Of the front, from 0 to 360, counter-clockwise from the right of the picture [deg]; None where not seen."""
        return (self.outline.axis + (0 if self.front > 0 else 180)) % 360 if self.front else None


@dataclass(frozen=True, slots=True)
class Approach:
    """Where a vehicle comes from.

    Attributes:
        pose: the first.
        heading: of its front, from 0 to 360, counter-clockwise from the right of the picture [deg].
        support: how much more speaks for it than for the next best that leads elsewhere.
        reasons: what speaks for it.
    """

    pose: VehiclePose
    heading: float
    support: float
    reasons: tuple[str, ...]


def angle_between(first: float, second: float) -> float:
    """From 0 to 180 [deg]."""
    return abs(math.remainder(first - second, 360.0))


def contact_point(poses: Sequence[VehiclePose]) -> tuple[float, float] | None:
    """Where two vehicles with different numbers touch [pixels]; the middle of the place where they come closest."""
    best: tuple[float, tuple[float, float]] | None = None
    shapes = [shapely.Polygon(pose.outline.corners()) for pose in poses]
    for first, pose in enumerate(poses):
        for second in range(first + 1, len(poses)):
            other = poses[second]
            if pose.number is None or other.number is None or pose.number == other.number:
                continue
            gap = float(shapes[first].distance(shapes[second])) / min(pose.outline.width, other.outline.width)
            if gap < _TOUCHING and (best is None or gap < best[0]):
                middle = shapely.shortest_line(shapes[first], shapes[second]).centroid
                best = gap, (float(middle.x), float(middle.y))
    return None if best is None else best[1]


def find_approaches(poses: Sequence[VehiclePose], arrows: Sequence[DrawnArrow]) -> Mapping[int, Approach]:
    """The approach of each numbered vehicle, where one stands out."""
    contact = contact_point(poses)
    found = {}
    for number in sorted({pose.number for pose in poses if pose.number is not None}):
        own = [pose for pose in poses if pose.number == number]
        approach = _approach(own, arrows, contact)
        if approach is not None:
            found[number] = approach
    return found


def _approach(
    poses: Sequence[VehiclePose], arrows: Sequence[DrawnArrow], contact: tuple[float, float] | None
) -> Approach | None:
    spacing = _spacing(poses)
    rated = []
    for index, pose in enumerate(poses):
        for heading in (pose.outline.axis % 360, (pose.outline.axis + 180) % 360):
            score, reasons = _rate(pose, heading, poses, arrows, contact)
            if spacing[index] > 0:
                score += _SPACED * spacing[index]
            rated.append((score, pose, heading, reasons))
    score, pose, heading, reasons = max(rated, key=lambda entry: entry[0])
    others = [other for other, _, way, _ in rated if angle_between(way, heading) > 45]
    support = score - max(others, default=0.0)
    return Approach(pose, heading, support, tuple(reasons)) if support > 0 and reasons else None


def _rate(
    pose: VehiclePose,
    heading: float,
    poses: Sequence[VehiclePose],
    arrows: Sequence[DrawnArrow],
    contact: tuple[float, float] | None,
) -> tuple[float, list[str]]:
    score, reasons = 0.0, []
    if pose.heading is not None:
        ahead = angle_between(pose.heading, heading) < 90
        score += _TRIANGLE if ahead else -_TRIANGLE
        if ahead:
            reasons.append("the triangle in it points that way")
    leaving = sum(_leaves(pose, heading, arrow) for arrow in arrows)
    score += _ARROW * max(-1, min(1, leaving))
    if leaving > 0:
        reasons.append("an arrow leads on from it")
    others = [other for other in poses if other is not pose]
    if others:
        shares = [_ahead(pose.outline.centre, heading, other.outline.centre) for other in others]
        score += _POSES_AHEAD * sum(shares) / len(shares)
        if sum(shares) > 0:
            reasons.append("its other places lie ahead")
    if contact is not None:
        distance = math.dist(contact, pose.outline.centre)
        furthest = max(math.dist(contact, other.outline.centre) for other in poses)
        if distance > 0.9 * pose.outline.length:
            share = _ahead(pose.outline.centre, heading, contact)
            score += _CONTACT_AHEAD * share + _FAR * distance / furthest
            if share > 0:
                reasons.append("the contact lies ahead")
    return score, reasons


def _ahead(begin: tuple[float, float], heading: float, end: tuple[float, float]) -> int:
    """1 where a point lies ahead, -1 where it lies behind, 0 aside."""
    way = math.degrees(math.atan2(begin[1] - end[1], end[0] - begin[0]))
    off = angle_between(way, heading)
    return 1 if off < _CONE else -1 if off > 180 - _CONE else 0


def _leaves(pose: VehiclePose, heading: float, arrow: DrawnArrow) -> int:
    """1 where an arrow leads on from the vehicle's front, -1 where it leads from its rear or arrives at its front."""
    outline = pose.outline
    reach = outline.length * 1.1
    near_tail = math.dist(arrow.tail, outline.centre) < reach
    near_tip = math.dist(arrow.tip, outline.centre) < reach
    if near_tail == near_tip:
        return 0
    # In line with the vehicle: arrows on the lanes beside it are another's.
    end = arrow.tail if near_tail else arrow.tip
    off = math.radians(outline.axis)
    aside = (end[0] - outline.centre[0]) * math.sin(off) + (end[1] - outline.centre[1]) * math.cos(off)
    if abs(aside) > 0.6 * outline.width:
        return 0
    turn = angle_between(arrow.heading, heading)
    if turn < _ARROW_CONE:
        return 1 if near_tail else 0
    return -1 if turn > 180 - _ARROW_CONE else 0


def _spacing(poses: Sequence[VehiclePose]) -> list[float]:
    """From -1 to 1 by pose: drawn wide apart are the places of an approach, close together those of the end."""
    if len(poses) < 4:
        return [0.0] * len(poses)
    centres = np.array([pose.outline.centre for pose in poses])
    distances = np.linalg.norm(centres[:, None] - centres[None], axis=2)
    np.fill_diagonal(distances, np.inf)
    nearest = distances.min(axis=1)
    middle = float(np.median(nearest))
    return [float(np.clip((value - middle) / max(1e-9, middle), -1.0, 1.0)) for value in nearest]
