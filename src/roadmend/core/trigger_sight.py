"""Where a participant that made a method step in was, as seen from the ego: for people, in words."""

import math
from dataclasses import dataclass
from typing import Any

from roadmend.core.appearance import kind_of
from roadmend.core.geometry import DISTANCE_EXACT, outline_distances, wrap_angle
from roadmend.core.repair import RepairTrigger
from roadmend.core.scene import EgoState, ObjectKind, ObjectList


@dataclass(frozen=True, slots=True)
class TriggerSight:
    """One of them; None where it was not seen: the bag holds no objects of that tick, or the guard dropped this one."""

    object_id: int
    weight: float  # in the method's own measure, larger is weightier
    kind: ObjectKind | None = None
    distance: float | None = None  # [m] between the outlines
    bearing: float | None = None  # [rad] of its centre, counter-clockwise from the ego's heading, -pi .. pi
    place: str = ""  # ahead, behind, left, right, two of them such as "ahead left", or "touching"

    @property
    def words(self) -> str:
        """It in a few words, such as "car 5 ahead left, 12 m"."""
        if self.kind is None or self.distance is None:
            return f"{self.object_id}"
        name = "object" if self.kind is ObjectKind.UNKNOWN else self.kind.name.lower()
        return f"{name} {self.object_id} {self.place}, {self.distance:.0f} m"

    def as_dict(self) -> dict[str, Any]:
        """Plain values, for JSON; the bearing in degrees, as people read it."""
        return {
            "id": self.object_id,
            "weight": self.weight,
            "kind": None if self.kind is None else self.kind.name.lower(),
            "distance": self.distance,
            "bearing_degrees": None if self.bearing is None else math.degrees(self.bearing),
            "place": self.place,
        }


def sight_of(trigger: RepairTrigger, ego: EgoState, objects: ObjectList) -> TriggerSight:
    """Where a participant is.

    Args:
        trigger: names it.
        ego: who looks.
        objects: among them.
    """
    other = objects.table[objects.id == trigger.object_id][:1]
    if not len(other) or not math.isfinite(float(other["x"][0] + other["y"][0])):
        return TriggerSight(trigger.object_id, trigger.weight)
    row = other[0]
    dx, dy = float(row["x"]) - ego.x, float(row["y"]) - ego.y
    return TriggerSight(
        trigger.object_id,
        trigger.weight,
        kind_of(int(row["kind"])),
        float(outline_distances(ego, other, DISTANCE_EXACT)[0]),
        wrap_angle(math.atan2(dy, dx) - ego.yaw),
        _place(ego, row),
    )


def _place(ego: EgoState, row: Any) -> str:
    """In words of the ego: ahead is what overlaps with the way straight on, ahead left what is left of that."""
    dx, dy, turn = float(row["x"]) - ego.x, float(row["y"]) - ego.y, float(row["yaw"]) - ego.yaw
    along = dx * math.cos(ego.yaw) + dy * math.sin(ego.yaw)
    across = dy * math.cos(ego.yaw) - dx * math.sin(ego.yaw)
    cosine, sine, length, width = abs(math.cos(turn)), abs(math.sin(turn)), float(row["length"]), float(row["width"])
    reach_along = 0.5 * (ego.length + length * cosine + width * sine)
    reach_across = 0.5 * (ego.width + length * sine + width * cosine)
    words = []
    if abs(along) > reach_along:
        words.append("ahead" if along > 0.0 else "behind")
    if abs(across) > reach_across:
        words.append("left" if across > 0.0 else "right")
    return " ".join(words) or "touching"
