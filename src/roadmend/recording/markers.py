"""One tick as markers: the participants, the ego with its repair, and the plan. Pure functions of core types."""

import math
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roadmend.core.appearance import (
    EGO_HEIGHT,
    KIND_COLOUR,
    KIND_HEIGHT,
    PLAN_COLOUR,
    SIGNAL_COLOUR,
    STATUS_COLOUR,
    TRIGGER_COLOUR,
    kind_of,
    signal_of,
)
from roadmend.core.command import Trajectory
from roadmend.core.geometry import fill_corners
from roadmend.core.repair import Repair, RepairStatus
from roadmend.core.route import Route
from roadmend.core.scene import EgoState, ObjectKind, ObjectList
from roadmend.recording.codec import MessageType
from roadmend.recording.marker_parts import (
    Shape,
    colour_of,
    complete_picture,
    line_of,
    marker_of,
    points_of,
    pose_of,
    text_of,
)
from roadmend.recording.messages import (
    BASE_FRAME,
    HEADER,
    NANOSECONDS,
    POINT,
    POSE,
    QUATERNION,
    VECTOR,
    stamp_message_of,
    stamp_of,
)

Floats = NDArray[np.float64]

OUTLINE_Z = 0.08  # [m] above the ground, so that it lies on top of lanes and route
OUTLINE_WIDTH = 0.12  # [m]
TRIGGER_WIDTH = 0.45  # [m]
TEXT_HEIGHT = 1.0  # [m]
SIGNAL_HEIGHT = 4.5  # [m] of the lamp above its stop line

PATH = MessageType("nav_msgs/msg/Path")
POSE_STAMPED = MessageType("geometry_msgs/msg/PoseStamped")
TRANSFORM = MessageType("geometry_msgs/msg/Transform")
TRANSFORM_STAMPED = MessageType("geometry_msgs/msg/TransformStamped")


@cache
def _colour(kind: ObjectKind) -> Any:
    return colour_of(KIND_COLOUR[kind], 0.85)


@cache
def _white() -> Any:
    return colour_of("#ffffff", 0.9)


def object_markers(
    objects: ObjectList,
    ego: EgoState,
    header: Any,
    *,
    triggers: frozenset[int] = frozenset(),
    text_radius: float = 40.0,
) -> Any:
    """A box for each participant, all outlines as one LINE_LIST, and what stands out about some of them.

    Objects with any number that is not finite are left out; a display would drop the whole message for them.

    Args:
        objects: the participants, frame map.
        ego: from whose centre ``text_radius`` is measured.
        header: stamp of the tick, frame map.
        triggers: ids of those that made the method step in: red, with a thick outline of their own and a text.
        text_radius: how near a participant must be to carry its id and speed [m].
    """
    columns = (objects.x, objects.y, objects.yaw, objects.speed, objects.length, objects.width)
    sound = objects.select(np.logical_and.reduce([np.isfinite(column) for column in columns]))
    near = np.hypot(sound.x - ego.x, sound.y - ego.y) <= text_radius
    boxes, extras, ends, colours = [], [], [], []
    rows = zip(
        sound.id.tolist(),
        sound.kind.tolist(),
        sound.x.tolist(),
        sound.y.tolist(),
        sound.yaw.tolist(),
        sound.speed.tolist(),
        sound.length.tolist(),
        sound.width.tolist(),
        near.tolist(),
        strict=True,
    )
    for identity, code, x, y, yaw, speed, length, width, is_near in rows:
        kind, triggered = kind_of(code), identity in triggers
        corners = outline_of(x, y, yaw, length, width)
        if triggered:
            extras.append(_trigger_outline(corners, identity, header))
        else:
            ends += [corners[0], corners[1], corners[1], corners[2], corners[2], corners[3], corners[3], corners[0]]
            colours += [_colour(kind)] * 8
        colour = colour_of(TRIGGER_COLOUR) if triggered else _colour(kind)
        height = KIND_HEIGHT[kind]
        boxes.append(_box(header, ("objects", identity), (x, y, yaw), (length, width, height), colour))
        if triggered or is_near:
            top = (x, y, height + 0.8 * TEXT_HEIGHT)
            label = f"{identity}  {speed:.1f} m/s"
            extras.append(text_of(header, ("labels", identity), label, at=top, height=TEXT_HEIGHT, colour=_white()))
    if ends:
        scale = (OUTLINE_WIDTH, 0.0, 0.0)
        kinds = {"points": ends, "colors": colours}
        boxes.append(marker_of(header, ("outlines", 0), Shape.LINE_LIST, _white(), scale, **kinds))
    return complete_picture(header, boxes + extras)


def signal_markers(route: Route, signals: NDArray[np.uint8], header: Any) -> list[Any]:
    """A lamp over each stop line that a traffic light governs."""
    found = []
    for index, zone in enumerate(route.zones):
        if 0 <= zone.signal < len(signals):
            x, y, _ = route.stages[zone.stage].pose(zone.begin)
            colour = colour_of(SIGNAL_COLOUR[signal_of(int(signals[zone.signal]))])
            pose = pose_of(x, y, SIGNAL_HEIGHT)
            found.append(marker_of(header, ("signals", index), Shape.SPHERE, colour, (0.9, 0.9, 0.9), pose=pose))
    return found


def ego_markers(ego: EgoState, repair: Repair | None, header: Any) -> Any:
    """The ego as a box with an arrow in the colour of the repair status, and a text that accounts for it."""
    colour = colour_of("#ffffff" if repair is None else STATUS_COLOUR[repair.status])
    pose = (ego.x, ego.y, ego.yaw)
    box = _box(header, ("ego", 0), pose, (ego.length, ego.width, EGO_HEIGHT), colour)
    place = POSE(position=POINT(x=ego.x, y=ego.y, z=EGO_HEIGHT + 0.2), orientation=_orientation(ego))
    arrow = marker_of(header, ("ego", 1), Shape.ARROW, _white(), (0.8 * ego.length, 0.35, 0.35), pose=place)
    corners = outline_of(ego.x, ego.y, ego.yaw, ego.length, ego.width)
    scale, points = (2.0 * OUTLINE_WIDTH, 0.0, 0.0), [*corners, corners[0]]
    outline = marker_of(header, ("ego", 2), Shape.LINE_STRIP, colour, scale, points=points)
    above = (ego.x, ego.y, EGO_HEIGHT + 2.5)
    text = text_of(
        header, ("ego_text", 0), caption_of(ego, repair), at=above, height=1.2 * TEXT_HEIGHT, colour=_white()
    )
    return complete_picture(header, [box, arrow, outline, text])


def caption_of(ego: EgoState, repair: Repair | None) -> str:
    """What the ego's text says: status, score against threshold, and, where the method stepped in, what and why."""
    if repair is None:
        return f"{ego.speed:.1f} m/s"
    lines = [f"{repair.status.name}  {ego.speed:.1f} m/s"]
    if math.isfinite(repair.score):
        against = ""
        if math.isfinite(repair.threshold):
            against = f" {'>' if repair.score > repair.threshold else '<='} {repair.threshold:.2f}"
        lines.append(f"score {repair.score:.2f}{against}")
    if repair.intervened or repair.status is not RepairStatus.PASS:
        worth = "" if repair.worth is None else f", worth {repair.worth:+.2f} collisions"
        lines.append(f"action {_signed(repair.policy_action)} -> {_signed(repair.final_action)}{worth}")
        if repair.reason:
            lines.append(repair.reason)
    return "\n".join(lines)


def plan_markers(trajectory: Trajectory, ego: EgoState, header: Any) -> Any:
    """The planned trajectory as a line from the ego on, with a sphere at each point."""
    sound = np.isfinite(trajectory.x) & np.isfinite(trajectory.y)
    if not sound.any():
        return complete_picture(header, [])
    x, y = trajectory.x[sound], trajectory.y[sound]
    line = (np.concatenate(([ego.x], x)), np.concatenate(([ego.y], y)))
    colour = colour_of(PLAN_COLOUR, 0.9)
    scale, points = (0.5, 0.5, 0.5), points_of(x, y, 0.35)
    spheres = marker_of(header, ("plan_points", 0), Shape.SPHERE_LIST, colour, scale, points=points)
    return complete_picture(header, [line_of(header, ("plan", 0), line, z=0.35, width=0.25, colour=colour), spheres])


def path_of(trajectory: Trajectory, header: Any) -> Any:
    """The planned trajectory as nav_msgs/Path; each pose has the frame and its own time, as displays want it."""
    poses = []
    for index in range(len(trajectory)):
        numbers = (float(trajectory.x[index]), float(trajectory.y[index]), float(trajectory.yaw[index]))
        if not all(math.isfinite(number) for number in numbers):
            continue
        due = stamp_of(header) + round((index + 1) * trajectory.interval * NANOSECONDS)
        at = HEADER(stamp=stamp_message_of(due), frame_id=header.frame_id)
        poses.append(POSE_STAMPED(header=at, pose=pose_of(numbers[0], numbers[1], 0.0, numbers[2])))
    return PATH(header=header, poses=poses)


def transform_of(ego: EgoState, header: Any) -> Any:
    """Pose of base_link in the header's frame."""
    transform = TRANSFORM(translation=VECTOR(x=ego.x, y=ego.y), rotation=_orientation(ego))
    return TRANSFORM_STAMPED(header=header, child_frame_id=BASE_FRAME, transform=transform)


def _orientation(ego: EgoState) -> Any:
    return QUATERNION(z=ego.orientation_z, w=ego.orientation_w)


def outline_of(x: float, y: float, yaw: float, length: float, width: float) -> list[Any]:
    """The four corners of an outline on the ground, counter-clockwise from front left."""
    corners = np.empty((4, 2), dtype=np.float64)
    fill_corners(corners, x, y, yaw, length, width)
    return points_of(corners[:, 0], corners[:, 1], OUTLINE_Z)


def _trigger_outline(corners: list[Any], identity: int, header: Any) -> Any:
    scale, points = (TRIGGER_WIDTH, 0.0, 0.0), [*corners, corners[0]]
    return marker_of(header, ("triggers", identity), Shape.LINE_STRIP, colour_of(TRIGGER_COLOUR), scale, points=points)


def _box(
    header: Any,
    group: tuple[str, int],
    pose: tuple[float, float, float],
    size: tuple[float, float, float],
    colour: Any,
) -> Any:
    x, y, yaw = pose
    return marker_of(header, group, Shape.CUBE, colour, size, pose=pose_of(x, y, 0.5 * size[2], yaw))


def _signed(action: float) -> str:
    return f"{action:+.2f}" if math.isfinite(action) else "none"
