"""What another participant did in the seconds before an incident, as the ego met it."""

import math
from dataclasses import dataclass

import numpy as np

from roadmend.core.geometry import wrap_angle
from roadmend.core.route import RightOfWay, Stage
from roadmend.core.scene import EgoState, ObjectKind
from roadmend.sera.descriptor import HazardKind, ParticipantKind, Side
from roadmend.sera.incident import Encounter
from roadmend.sera.track import Track

_CROSSING_FROM, _ONCOMING_FROM = math.radians(45.0), math.radians(135.0)  # between the headings
_TURNED = math.radians(25.0)  # who is oncoming and turns by as much crosses the ego's way
_LANE = 1.6  # [m] half a lane
_MOVED_IN = 0.8  # [m] toward the middle of the ego's lane
_BRAKED = 3.0  # [m/s2] harder than drivers brake for comfort
_STOOD = 0.5  # [m/s]

KINDS: dict[int, ParticipantKind] = {
    ObjectKind.CAR: "car",
    ObjectKind.TRUCK: "truck",
    ObjectKind.BUS: "bus",
    ObjectKind.MOTORCYCLE: "motorcycle",
    ObjectKind.BICYCLE: "bicycle",
    ObjectKind.PEDESTRIAN: "pedestrian",
}


@dataclass(frozen=True, slots=True)
class Met:
    """The kind of an encounter."""

    encounter: Encounter
    side: Side  # of the ego when it began


def classify(track: Track, ego: EgoState, heading: float, stage: Stage, position: float, *, changing: bool) -> Met:
    """Tell what kind of encounter it was.

    Args:
        track: the other's way since the encounter began.
        ego: at the track's first moment.
        heading: of the ego [rad] before it turned, if it turns; otherwise that of ``ego``.
        stage: the lane that the ego is on in the end.
        position: of the ego on it [m], in the end.
        changing: whether the ego is changing lanes in the end.
    """
    dx, dy = track.x[0] - ego.x, track.y[0] - ego.y
    is_ahead = dx * math.cos(ego.yaw) + dy * math.sin(ego.yaw) > 0.0
    _, first = stage.project(float(track.x[0]), float(track.y[0]), position, 80.0)
    _, last = stage.project(float(track.x[-1]), float(track.y[-1]), position, 80.0)
    flank: Side = "left" if first > 0.0 else "right"
    if track.kind == ObjectKind.PEDESTRIAN:
        return Met("pedestrian", flank)
    angle = wrap_angle(float(track.yaw[0]) - heading)
    if abs(angle) > _ONCOMING_FROM:
        turned = abs(float(np.sum([wrap_angle(float(step)) for step in np.diff(track.yaw)])))
        return Met("oncoming_turn" if turned > _TURNED else "oncoming", "oncoming")
    if abs(angle) > _CROSSING_FROM:
        return Met("crossing_from_left", "left") if angle < 0.0 else Met("crossing_from_right", "right")
    across = dy * math.cos(ego.yaw) - dx * math.sin(ego.yaw)
    if changing and abs(across) > _LANE:
        return Met("in_target_lane", "left" if across > 0.0 else "right")
    if abs(first) > _LANE and abs(last) < abs(first) - _MOVED_IN:
        return Met("cut_in", flank)
    if abs(first) > _LANE and abs(across) > _LANE:
        return Met("alongside", flank)
    if not is_ahead:
        return Met("follower", "behind")
    if track.speed[0] < _STOOD:
        return Met("standing_leader", "ahead")
    return Met("braking_leader" if braking_of(track) > _BRAKED else "slow_leader", "ahead")


def braking_of(track: Track) -> float:
    """The hardest deceleration [m/s2]."""
    return max(0.0, -float(track.acceleration.min()))


def hazard_of(met: Met, track: Track, right_of_way: str | None) -> HazardKind | None:
    """What the other did that the ego had to cope with, by the rule that held for the ego; None for nothing wrong."""
    match met.encounter:
        case "pedestrian":
            return "pedestrian_crossing"
        case "cut_in":
            return "cut_in_and_brake" if braking_of(track) > _BRAKED else "cut_in"
        case "braking_leader":
            return "hard_braking"
        case "crossing_from_left" | "crossing_from_right" | "oncoming_turn":
            return "run_right_of_way" if right_of_way == RightOfWay.PRIORITY.name.lower() else None
        case _:
            return None
