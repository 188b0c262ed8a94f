"""Ego and objects as other stacks publish them, as core types. Needs no ROS.

What is read from another stack need not share stamps, rates or frames with the rest; ``recording.foreign_repair`` puts
it together.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from roadmend.core.geometry import wrap_angle
from roadmend.core.scene import EgoState, ObjectKind, ObjectList
from roadmend.recording import messages

Signals = NDArray[np.uint8]

TRACK_GAP = 1.0  # [s] an object that was not seen for longer is a new one, and so are all where a stamp is further back
LEAP = 100.0  # [m/s] what moves faster was taken for something else, now or before
SMOOTHING = 0.2  # [s] time constant of the velocities that are worked out from positions
STILL = 0.5  # [m/s] a slower object keeps the heading of its box
CARRY = 0.2  # [s] for which the ego's motion is carried on to the stamp of what was seen from it
SQUARE = 1.5  # a box that is less longer than wide than this says nothing of the heading
FIRST_NAMED = 1 << 31  # ids below are those that the detector counts itself

_KINDS = {
    "car": ObjectKind.CAR,
    "vehicle": ObjectKind.CAR,
    "van": ObjectKind.CAR,
    "truck": ObjectKind.TRUCK,
    "trailer": ObjectKind.TRUCK,
    "bus": ObjectKind.BUS,
    "motorcycle": ObjectKind.MOTORCYCLE,
    "motorbike": ObjectKind.MOTORCYCLE,
    "bicycle": ObjectKind.BICYCLE,
    "cyclist": ObjectKind.BICYCLE,
    "pedestrian": ObjectKind.PEDESTRIAN,
    "person": ObjectKind.PEDESTRIAN,
}


@dataclass(frozen=True, slots=True)
class EgoOutline:
    """What odometry does not tell of the ego."""

    length: float  # [m]
    width: float  # [m]
    centre: float = 0.0  # [m] of the outline, ahead of the frame that odometry is about


@dataclass(frozen=True, slots=True)
class EgoPose:
    """The ego at one moment, and the frames that its odometry names."""

    ego: EgoState
    stamp: int  # [ns]
    frame: str  # in which it is
    base_frame: str  # that moves with it
    x: float  # [m] of the base frame
    y: float  # [m]

    def base_at(self, stamp: int) -> tuple[float, float, float]:
        """Position [m] and heading [rad] of the base frame at another moment [ns], at constant speed and yaw rate.

        No more than ``CARRY`` away from the odometry's own: stamps of two clocks may differ by anything.
        """
        passed = min(CARRY, max(-CARRY, 1e-9 * (stamp - self.stamp)))
        middle, way = self.ego.yaw + 0.5 * passed * self.ego.yaw_rate, passed * self.ego.speed
        yaw = self.ego.yaw + passed * self.ego.yaw_rate
        return self.x + way * math.cos(middle), self.y + way * math.sin(middle), yaw


def yaw_of(orientation: Any) -> float:
    """Heading [rad] of a quaternion that need not be of unit length nor about the vertical; NaN for one of length 0."""
    x, y, z, w = orientation.x, orientation.y, orientation.z, orientation.w
    length = x * x + y * y + z * z + w * w
    if not length > 0.0:
        return math.nan
    return math.atan2(2.0 * (w * z + x * y), length - 2.0 * (y * y + z * z))


def ego_pose_of(message: Any, vehicle: EgoOutline) -> EgoPose:
    """The ego from nav_msgs/Odometry: the pose in header.frame_id, the twist in child_frame_id (REP 103, REP 105)."""
    pose, twist = message.pose.pose, message.twist.twist
    yaw = yaw_of(pose.orientation)
    x, y = pose.position.x, pose.position.y
    ego = EgoState.from_yaw(
        x + vehicle.centre * math.cos(yaw),
        y + vehicle.centre * math.sin(yaw),
        yaw,
        twist.linear.x,
        twist.angular.z,
        vehicle.length,
        vehicle.width,
    )
    return EgoPose(ego, messages.stamp_of(message.header), message.header.frame_id, message.child_frame_id, x, y)


class ObjectReader(Protocol):
    """Makes object lists of one type of message; may remember what it has seen."""

    type_name: str  # package/msg/Name

    def read(self, message: Any, pose: EgoPose) -> tuple[ObjectList, Signals]:
        """What the message tells, in the frame of the ego's pose.

        Raises:
            ValueError: it is not usable; why, in words.
        """


class OwnObjects:
    """roadmend_msgs/ObjectList: all that repair looks at, in the frame of the odometry."""

    type_name = "roadmend_msgs/msg/ObjectList"

    def read(self, message: Any, pose: EgoPose) -> tuple[ObjectList, Signals]:
        """As it is.

        Raises:
            ValueError: another frame than the ego's, or arrays that differ in length.
        """
        if message.header.frame_id != pose.frame:
            raise ValueError(_other_frame(message.header.frame_id, pose.frame))
        return messages.objects_of(message)


@dataclass(slots=True)
class _Track:
    number: int
    stamp: int  # [ns] when it was seen last
    x: float  # [m] then
    y: float  # [m]
    velocity: tuple[float, float] | None = None  # [m/s]; None until it was seen twice


class Detections:
    """vision_msgs/Detection3DArray: boxes without a velocity, which is worked out from where each id was before.

    - An object counts from its second sighting on: its first says nothing of its speed, and a wrong one brakes for
      whoever overtakes. One that nobody follows (an empty id) counts at once, as standing. So does one that is seen
      again while no time passes by its stamps: to leave it out would be to drive into it.
    - One that is farther from where it was than anybody drives counts as standing where it is said to be: to leave it out
      would be to drive into it, if it is there.
    - A list that is stamped before the one before it, as of a slower sensor or a clock that was set a little, leaves
      nobody out either: who is known keeps his velocity, and is followed from there.
    - A list without a stamp is taken to be of the odometry's moment.
    - The frame may be the odometry's or the one that moves with the ego.
    - The heading is that axis of the box which is nearest to the motion; of a box that is about as long as wide, the
      motion itself. Of one that stands, the box's own.
    - The kind is that of the likeliest hypothesis, where its name is a known one.
    """

    type_name = "vision_msgs/msg/Detection3DArray"

    def __init__(self) -> None:
        self._tracks: dict[str, _Track] = {}
        self._named = 0
        self._stamp = -1  # [ns] of the last message

    def read(self, message: Any, pose: EgoPose) -> tuple[ObjectList, Signals]:
        """The objects that have been seen twice, and those without an id; no traffic lights.

        Raises:
            ValueError: the frame is neither the odometry's nor the one that moves with the ego.
        """
        frame = message.header.frame_id
        if frame not in {pose.frame, pose.base_frame}:
            raise ValueError(_other_frame(frame, f"{pose.frame} or {pose.base_frame}"))
        stamp = messages.stamp_of(message.header) or pose.stamp
        if self._stamp - stamp > TRACK_GAP * 1e9:  # a new run, or a replay from the start
            self._tracks.clear()
        self._stamp = stamp
        self._tracks = {name: track for name, track in self._tracks.items() if stamp - track.stamp <= TRACK_GAP * 1e9}
        seen = [self._see(one, index, stamp, pose, frame) for index, one in enumerate(message.detections)]
        rows = [row for row in seen if row is not None]
        names = ("id", "kind", "x", "y", "yaw", "speed", "length", "width")
        columns = dict(zip(names, zip(*rows, strict=True), strict=True)) if rows else dict.fromkeys(names, ())
        none: Signals = np.empty(0, dtype=np.uint8)
        return ObjectList.of(**columns, acceleration=0.0, yaw_rate=0.0), none

    def _see(self, one: Any, index: int, stamp: int, pose: EgoPose, frame: str) -> tuple[float, ...] | None:
        centre, size = one.bbox.center, one.bbox.size
        x, y, yaw = centre.position.x, centre.position.y, yaw_of(centre.orientation)
        if frame != pose.frame:
            base_x, base_y, base_yaw = pose.base_at(stamp)
            cosine, sine = math.cos(base_yaw), math.sin(base_yaw)
            x, y, yaw = base_x + x * cosine - y * sine, base_y + x * sine + y * cosine, yaw + base_yaw
        kind, length, width = _kind_of(one.results), size.x, size.y
        is_placed = math.isfinite(x + y)  # else the guard tells; it must not spoil what is known of the object
        if not one.id or not is_placed:
            return FIRST_NAMED + 10_000_000 + index, kind, x, y, yaw, 0.0, length, width
        if one.id not in self._tracks:
            self._tracks[one.id] = _Track(self._number(one.id), stamp, x, y)
            return None
        track = self._follow(self._tracks[one.id], stamp, x, y)
        vx, vy = track.velocity or (0.0, 0.0)
        pace = math.hypot(vx, vy)
        if pace > STILL and math.isfinite(yaw):
            motion = math.atan2(vy, vx)
            if max(length, width) < SQUARE * min(length, width):
                yaw = motion
            else:
                quarters = round(wrap_angle(motion - yaw) / (0.5 * math.pi))
                yaw = wrap_angle(yaw + 0.5 * math.pi * quarters)
                if quarters % 2:
                    length, width = width, length
        return track.number, kind, x, y, yaw, vx * math.cos(yaw) + vy * math.sin(yaw), length, width

    def _follow(self, track: _Track, stamp: int, x: float, y: float) -> _Track:
        passed = 1e-9 * (stamp - track.stamp)
        if passed == 0.0:
            return track
        if passed < 0.0:  # it tells no velocity, but the way from here on belongs to the time from here on
            track.stamp, track.x, track.y = stamp, x, y
            return track
        moved = (x - track.x) / passed, (y - track.y) / passed
        track.stamp, track.x, track.y = stamp, x, y
        if not math.hypot(*moved) <= LEAP:
            track.velocity = None
            return track
        share = 1.0 if track.velocity is None else 1.0 - math.exp(-passed / SMOOTHING)
        before = track.velocity or (0.0, 0.0)
        track.velocity = (
            before[0] + share * (moved[0] - before[0]),
            before[1] + share * (moved[1] - before[1]),
        )
        return track

    def _number(self, name: str) -> int:
        if name.isdecimal() and len(name) <= 10 and str(int(name)) == name and int(name) < FIRST_NAMED:
            return int(name)  # "07" is somebody else
        self._named += 1
        return FIRST_NAMED + self._named


OBJECT_READERS: dict[str, Callable[[], ObjectReader]] = {
    OwnObjects.type_name: OwnObjects,
    Detections.type_name: Detections,
}


def _kind_of(results: Any) -> ObjectKind:
    best = max(results, key=lambda one: one.hypothesis.score, default=None)
    name = "" if best is None else best.hypothesis.class_id
    parts = reversed(name.lower().replace("/", ".").split("."))
    return next((_KINDS[part] for part in parts if part in _KINDS), ObjectKind.UNKNOWN)


def _other_frame(given: str, wanted: str) -> str:
    return f"objects are in the frame {given!r}, not in {wanted}"
