"""Small parts from which every marker is made."""

import math
from collections.abc import Iterable
from enum import IntEnum
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roadmend.recording.codec import MessageType
from roadmend.recording.messages import POINT, POSE, QUATERNION, VECTOR

Floats = NDArray[np.float64]

COLOUR = MessageType("std_msgs/msg/ColorRGBA")
MARKER = MessageType("visualization_msgs/msg/Marker")
MARKER_ARRAY = MessageType("visualization_msgs/msg/MarkerArray")

_DELETE_ALL = 3  # Marker.DELETEALL


class Shape(IntEnum):
    """What a marker is; mirrors visualization_msgs/Marker."""

    ARROW = 0
    CUBE = 1
    SPHERE = 2
    LINE_STRIP = 4
    LINE_LIST = 5
    SPHERE_LIST = 7
    TEXT_VIEW_FACING = 9
    TRIANGLE_LIST = 11


def colour_of(hexadecimal: str, alpha: float = 1.0) -> Any:
    """A colour written #rrggbb; ``alpha`` is its opacity in 0..1."""
    red, green, blue = (int(hexadecimal[begin : begin + 2], 16) / 255.0 for begin in (1, 3, 5))
    return COLOUR(r=red, g=green, b=blue, a=alpha)


def complete_picture(header: Any, markers: Iterable[Any]) -> Any:
    """The markers behind one that deletes all earlier ones, so that the message stands for itself after a seek."""
    return MARKER_ARRAY(markers=[MARKER(header=header, action=_DELETE_ALL, pose=_origin()), *markers])


@cache
def _origin() -> Any:
    return pose_of(0.0, 0.0, 0.0)


def pose_of(x: float, y: float, z: float, yaw: float = 0.0) -> Any:
    """A place [m] and a heading [rad]."""
    return POSE(position=POINT(x=x, y=y, z=z), orientation=QUATERNION(z=math.sin(0.5 * yaw), w=math.cos(0.5 * yaw)))


def marker_of(
    header: Any,
    group: tuple[str, int],
    shape: Shape,
    colour: Any,
    scale: tuple[float, float, float],
    **fields: Any,
) -> Any:
    """A marker, at the origin of the header's frame unless ``fields`` has a pose.

    Args:
        header: stamp and frame.
        group: namespace that a display can switch on and off, and a number that is unique within it; reduced to the
            31 bits that a marker has for it.
        shape: what it is.
        colour: of the whole marker.
        scale: size along x, y, z [m]; lines take their width from the first, texts their height from the last.
        fields: others of visualization_msgs/Marker.
    """
    namespace, identity = group
    size = VECTOR(x=scale[0], y=scale[1], z=scale[2])
    known = {"pose": _origin(), "ns": namespace, "id": identity & 0x7FFFFFFF, "type": int(shape)}
    return MARKER(**(known | {"header": header, "color": colour, "scale": size} | fields))


def line_of(
    header: Any, group: tuple[str, int], line: tuple[Floats, Floats], *, z: float, width: float, colour: Any
) -> Any:
    """A LINE_STRIP through x and y (shape (P,) each) at height ``z`` [m]."""
    points = points_of(line[0], line[1], z)
    return marker_of(header, group, Shape.LINE_STRIP, colour, (width, 0.0, 0.0), points=points)


def text_of(
    header: Any, group: tuple[str, int], text: str, *, at: tuple[float, float, float], height: float, colour: Any
) -> Any:
    """A text that faces the viewer, its centre ``at`` x, y, z [m], its capitals ``height`` [m] high."""
    scale = (0.0, 0.0, height)
    return marker_of(header, group, Shape.TEXT_VIEW_FACING, colour, scale, pose=pose_of(*at), text=text)


def points_of(x: Floats, y: Floats, z: float) -> list[Any]:
    """Points at height ``z`` [m] from two arrays of shape (P,)."""
    return [POINT(x=px, y=py, z=z) for px, py in zip(x.tolist(), y.tolist(), strict=True)]
