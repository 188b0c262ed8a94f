"""Small parts from which every marker is made."""

from collections.abc import Iterable

import numpy as np
from geometry_msgs.msg import Point
from numpy.typing import NDArray
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

Floats = NDArray[np.float64]


def colour_of(hexadecimal: str, alpha: float = 1.0) -> ColorRGBA:
    """A colour written #rrggbb as a message; ``alpha`` is its opacity in 0..1."""
    red, green, blue = (int(hexadecimal[begin : begin + 2], 16) / 255.0 for begin in (1, 3, 5))
    return ColorRGBA(r=red, g=green, b=blue, a=alpha)


def complete_picture(header: Header, markers: Iterable[Marker]) -> MarkerArray:
    """The markers behind one that deletes all earlier ones, so that the message stands for itself after a seek."""
    return MarkerArray(markers=[Marker(header=header, action=Marker.DELETEALL), *markers])


def marker_of(
    header: Header, namespace: str, identity: int, shape: int, colour: ColorRGBA, scale: tuple[float, float, float]
) -> Marker:
    """A marker at the origin of the header's frame.

    Args:
        header: stamp and frame.
        namespace: group that a display can switch on and off.
        identity: unique within the namespace; reduced to the 31 bits that a marker has for it.
        shape: one of the type constants of Marker.
        colour: of the whole marker.
        scale: size along x, y, z [m]; lines take their width from the first, texts their height from the last.
    """
    marker = Marker(header=header, ns=namespace, id=identity & 0x7FFFFFFF, type=shape, color=colour)
    marker.scale.x, marker.scale.y, marker.scale.z = scale
    marker.pose.orientation.w = 1.0
    return marker


def line_of(
    header: Header,
    namespace: str,
    identity: int,
    line: tuple[Floats, Floats],
    *,
    z: float,
    width: float,
    colour: ColorRGBA,
) -> Marker:
    """A LINE_STRIP through x and y (shape (P,) each) at height ``z`` [m]."""
    marker = marker_of(header, namespace, identity, Marker.LINE_STRIP, colour, (width, 0.0, 0.0))
    marker.points = points_of(line[0], line[1], z)
    return marker


def text_of(
    header: Header,
    namespace: str,
    identity: int,
    text: str,
    *,
    at: tuple[float, float, float],
    height: float,
    colour: ColorRGBA,
) -> Marker:
    """A text that faces the viewer, its centre ``at`` x, y, z [m], its capitals ``height`` [m] high."""
    marker = marker_of(header, namespace, identity, Marker.TEXT_VIEW_FACING, colour, (0.0, 0.0, height))
    position = marker.pose.position
    position.x, position.y, position.z = at
    marker.text = text
    return marker


def points_of(x: Floats, y: Floats, z: float) -> list[Point]:
    """Points at height ``z`` [m] from two arrays of shape (P,)."""
    return [Point(x=px, y=py, z=z) for px, py in zip(x.tolist(), y.tolist(), strict=True)]
