"""One tick as markers: the participants, the ego with its repair, and the plan. Pure functions of core types."""

import math

import numpy as np
from geometry_msgs.msg import Point, PoseStamped, TransformStamped
from nav_msgs.msg import Path
from numpy.typing import NDArray
from roadmend_msgs import msg
from std_msgs.msg import Header
from visualization_msgs.msg import Marker, MarkerArray

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
    status_of,
)
from roadmend.core.command import Trajectory
from roadmend.core.geometry import fill_corners
from roadmend.core.repair import RepairStatus
from roadmend.core.route import Route
from roadmend.core.scene import EgoState, ObjectList
from roadmend.nodes.convert import BASE_FRAME
from roadmend.nodes.marker_parts import colour_of, complete_picture, line_of, marker_of, points_of, text_of

Floats = NDArray[np.float64]

OUTLINE_Z = 0.08  # [m] above the ground, so that it lies on top of lanes and route
OUTLINE_WIDTH = 0.12  # [m]
TRIGGER_WIDTH = 0.45  # [m]
TEXT_HEIGHT = 1.0  # [m]
SIGNAL_HEIGHT = 4.5  # [m] of the lamp above its stop line

_COLOURS = {kind: colour_of(colour, 0.85) for kind, colour in KIND_COLOUR.items()}
_WHITE = colour_of("#ffffff", 0.9)


def object_markers(
    objects: ObjectList,
    ego: EgoState,
    header: Header,
    *,
    triggers: frozenset[int] = frozenset(),
    text_radius: float = 40.0,
) -> MarkerArray:
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
            colours += [_COLOURS[kind]] * 8
        colour = colour_of(TRIGGER_COLOUR) if triggered else _COLOURS[kind]
        height = KIND_HEIGHT[kind]
        boxes.append(_box(header, "objects", identity, (x, y, yaw), (length, width, height), colour))
        if triggered or is_near:
            top = (x, y, height + 0.8 * TEXT_HEIGHT)
            label = f"{identity}  {speed:.1f} m/s"
            extras.append(text_of(header, "labels", identity, label, at=top, height=TEXT_HEIGHT, colour=_WHITE))
    if ends:
        outlines = marker_of(header, "outlines", 0, Marker.LINE_LIST, _WHITE, (OUTLINE_WIDTH, 0.0, 0.0))
        outlines.points, outlines.colors = ends, colours
        boxes.append(outlines)
    return complete_picture(header, boxes + extras)


def signal_markers(route: Route, signals: NDArray[np.uint8], header: Header) -> list[Marker]:
    """A lamp over each stop line that a traffic light governs."""
    found = []
    for index, zone in enumerate(route.zones):
        if 0 <= zone.signal < len(signals):
            x, y, _ = route.stages[zone.stage].pose(zone.begin)
            colour = colour_of(SIGNAL_COLOUR[signal_of(int(signals[zone.signal]))])
            lamp = marker_of(header, "signals", index, Marker.SPHERE, colour, (0.9, 0.9, 0.9))
            lamp.pose.position.x, lamp.pose.position.y, lamp.pose.position.z = x, y, SIGNAL_HEIGHT
            found.append(lamp)
    return found


def ego_markers(ego: EgoState, state: msg.RepairState | None, header: Header) -> MarkerArray:
    """The ego as a box with an arrow in the colour of the repair state, and a text that accounts for it."""
    status = None if state is None else status_of(state.state)
    colour = colour_of("#ffffff" if status is None else STATUS_COLOUR[status])
    pose = (ego.x, ego.y, ego.yaw)
    box = _box(header, "ego", 0, pose, (ego.length, ego.width, EGO_HEIGHT), colour)
    arrow = marker_of(header, "ego", 1, Marker.ARROW, _WHITE, (0.8 * ego.length, 0.35, 0.35))
    arrow.pose.position.x, arrow.pose.position.y = ego.x, ego.y
    arrow.pose.position.z = EGO_HEIGHT + 0.2
    arrow.pose.orientation.z, arrow.pose.orientation.w = ego.orientation_z, ego.orientation_w
    corners = outline_of(ego.x, ego.y, ego.yaw, ego.length, ego.width)
    outline = marker_of(header, "ego", 2, Marker.LINE_STRIP, colour, (2.0 * OUTLINE_WIDTH, 0.0, 0.0))
    outline.points = [*corners, corners[0]]
    above = (ego.x, ego.y, EGO_HEIGHT + 2.5)
    text = text_of(header, "ego_text", 0, caption_of(ego, state), at=above, height=1.2 * TEXT_HEIGHT, colour=_WHITE)
    return complete_picture(header, [box, arrow, outline, text])


def caption_of(ego: EgoState, state: msg.RepairState | None) -> str:
    """What the ego's text says: state, score against threshold, and, where the method stepped in, what and why."""
    if state is None:
        return f"{ego.speed:.1f} m/s"
    lines = [f"{status_of(state.state).name}  {ego.speed:.1f} m/s"]
    if math.isfinite(state.score):
        against = ""
        if math.isfinite(state.threshold):
            against = f" {'>' if state.score > state.threshold else '<='} {state.threshold:.2f}"
        lines.append(f"score {state.score:.2f}{against}")
    if state.intervened or status_of(state.state) is not RepairStatus.PASS:
        lines.append(f"action {_signed(state.policy_action)} -> {_signed(state.final_action)}")
        if state.reason:
            lines.append(state.reason)
    return "\n".join(lines)


def plan_markers(trajectory: Trajectory, ego: EgoState, header: Header) -> MarkerArray:
    """The planned trajectory as a line from the ego on, with a sphere at each point."""
    sound = np.isfinite(trajectory.x) & np.isfinite(trajectory.y)
    if not sound.any():
        return complete_picture(header, [])
    x, y = trajectory.x[sound], trajectory.y[sound]
    line = (np.concatenate(([ego.x], x)), np.concatenate(([ego.y], y)))
    colour = colour_of(PLAN_COLOUR, 0.9)
    spheres = marker_of(header, "plan_points", 0, Marker.SPHERE_LIST, colour, (0.5, 0.5, 0.5))
    spheres.points = points_of(x, y, 0.35)
    return complete_picture(header, [line_of(header, "plan", 0, line, z=0.35, width=0.25, colour=colour), spheres])


def path_of(trajectory: Trajectory, header: Header) -> Path:
    """The planned trajectory as nav_msgs/Path; each pose has the frame and its own time, as displays want it."""
    path = Path(header=header)
    begin = header.stamp.sec * 1_000_000_000 + header.stamp.nanosec
    for index in range(len(trajectory)):
        numbers = (float(trajectory.x[index]), float(trajectory.y[index]), float(trajectory.yaw[index]))
        if not all(math.isfinite(number) for number in numbers):
            continue
        stamped = PoseStamped()
        due = begin + round((index + 1) * trajectory.interval * 1e9)
        stamped.header.frame_id = header.frame_id
        stamped.header.stamp.sec, stamped.header.stamp.nanosec = divmod(due, 1_000_000_000)
        stamped.pose.position.x, stamped.pose.position.y = numbers[0], numbers[1]
        stamped.pose.orientation.z, stamped.pose.orientation.w = (
            math.sin(0.5 * numbers[2]),
            math.cos(0.5 * numbers[2]),
        )
        path.poses.append(stamped)
    return path


def transform_of(ego: EgoState, header: Header) -> TransformStamped:
    """Pose of base_link in the header's frame."""
    stamped = TransformStamped(header=header, child_frame_id=BASE_FRAME)
    stamped.transform.translation.x, stamped.transform.translation.y = ego.x, ego.y
    stamped.transform.rotation.z, stamped.transform.rotation.w = ego.orientation_z, ego.orientation_w
    return stamped


def outline_of(x: float, y: float, yaw: float, length: float, width: float) -> list[Point]:
    """The four corners of an outline on the ground, counter-clockwise from front left."""
    corners = np.empty((4, 2), dtype=np.float64)
    fill_corners(corners, x, y, yaw, length, width)
    return points_of(corners[:, 0], corners[:, 1], OUTLINE_Z)


def _trigger_outline(corners: list[Point], identity: int, header: Header) -> Marker:
    scale = (TRIGGER_WIDTH, 0.0, 0.0)
    outline = marker_of(header, "triggers", identity, Marker.LINE_STRIP, colour_of(TRIGGER_COLOUR), scale)
    outline.points = [*corners, corners[0]]
    return outline


def _box(
    header: Header,
    namespace: str,
    identity: int,
    pose: tuple[float, float, float],
    size: tuple[float, float, float],
    colour: object,
) -> Marker:
    marker = marker_of(header, namespace, identity, Marker.CUBE, colour, size)
    marker.pose.position.x, marker.pose.position.y, marker.pose.position.z = pose[0], pose[1], 0.5 * size[2]
    marker.pose.orientation.z, marker.pose.orientation.w = math.sin(0.5 * pose[2]), math.cos(0.5 * pose[2])
    return marker


def _signed(action: float) -> str:
    return f"{action:+.2f}" if math.isfinite(action) else "none"
