"""What kind of collision ended an episode, in one word and in one line."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roadmend.core.geometry import fill_corners, wrap_angle
from roadmend.core.outcome import Event, EventKind
from roadmend.core.scene import ObjectKind, Scene

Floats = NDArray[np.float64]

_MANNERS = {
    ("front", "rear"): "ran into",
    ("front", "side"): "struck flank",
    ("front", "front"): "head on",
    ("rear", "front"): "hit from behind",
    ("rear", "rear"): "backs met",
    ("rear", "side"): "tail clipped",
    ("side", "front"): "hit in the side",
    ("side", "rear"): "sideswipe",
    ("side", "side"): "sideswipe",
}


@dataclass(frozen=True, slots=True)
class CollisionConfiguration:
    """How the ego and another met."""

    manner: str  # one of the words above
    other: str  # kind of the other, in small letters
    name: str  # of the other in the scenario
    ego_speed: float  # [m/s]
    other_speed: float  # [m/s]
    angle: float  # [deg] between the headings, 0 .. 180

    @property
    def text(self) -> str:
        """In one line."""
        return (
            f"{self.manner}: ego at {self.ego_speed:.1f} m/s, {self.other} {self.name} at {self.other_speed:.1f} m/s, "
            f"headings {self.angle:.0f} deg apart"
        )


def describe_collision(scene: Scene, event: Event) -> CollisionConfiguration | None:
    """The collision that ``event`` reports, from the last scene before it; None where the other was not yet seen."""
    if event.kind != EventKind.COLLISION or not event.object_ids:
        return None
    number, name = event.object_ids[0], next(iter(event.object_names), "")
    found = np.flatnonzero(scene.objects.id == number)
    if not len(found):
        return None
    index, ego, objects = int(found[0]), scene.ego, scene.objects
    own = np.array([ego.x, ego.y, ego.yaw, ego.length, ego.width])
    their = np.array(
        [
            objects.x[index],
            objects.y[index],
            objects.yaw[index],
            objects.length[index],
            objects.width[index],
        ]
    )
    parts = _part(own, their), _part(their, own)
    return CollisionConfiguration(
        _MANNERS[parts],
        ObjectKind(int(objects.kind[index])).name.lower(),
        name,
        ego.speed,
        float(objects.speed[index]),
        abs(math.degrees(wrap_angle(float(objects.yaw[index]) - ego.yaw))),
    )


def _part(box: Floats, other: Floats) -> str:
    """Which part of ``box`` (x, y, yaw, length, width) is nearest to ``other``: front, rear or side."""
    corners = np.empty((4, 2))
    fill_corners(corners, *other)
    share = np.linspace(0.0, 1.0, 21)[:, None, None]
    outline = (corners * (1.0 - share) + np.roll(corners, -1, axis=0) * share).reshape(-1, 2) - box[:2]
    cosine, sine = math.cos(box[2]), math.sin(box[2])
    along = outline[:, 0] * cosine + outline[:, 1] * sine
    across = outline[:, 1] * cosine - outline[:, 0] * sine
    over_end, over_side = np.abs(along) - 0.5 * box[3], np.abs(across) - 0.5 * box[4]
    gap = np.hypot(np.maximum(over_end, 0.0), np.maximum(over_side, 0.0))
    nearest = int(np.argmin(gap + 1e-3 * np.abs(across)))
    if over_side[nearest] > over_end[nearest]:
        return "side"
    return "front" if along[nearest] > 0.0 else "rear"
