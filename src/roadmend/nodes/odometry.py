"""The ego as nav_msgs/Odometry on the hot path.

The two covariance arrays make this message the dearest of all: 30 us to build, 40 us to read. Built once and filled
anew each tick, and read straight from its bytes, it costs a tenth of that.
"""

import struct

from nav_msgs.msg import Odometry
from std_msgs.msg import Header

from roadmend.core.scene import EgoState
from roadmend.nodes.convert import BASE_FRAME

_HEADER = 4  # bytes of encapsulation before the first field; alignment counts from here
_POSE = struct.Struct("<7d")  # position x, y, z; orientation x, y, z, w
_TWIST = struct.Struct("<6d")  # linear x, y, z; angular x, y, z
_COVARIANCE = 36 * 8  # bytes


class OdometryWriter:
    """One message, filled anew for each tick."""

    def __init__(self) -> None:
        self._message = Odometry(child_frame_id=BASE_FRAME)

    def fill(self, ego: EgoState, header: Header) -> Odometry:
        """The ego as a message; valid until the next call."""
        message = self._message
        message.header = header
        position, orientation = message.pose.pose.position, message.pose.pose.orientation
        position.x, position.y = ego.x, ego.y
        orientation.z, orientation.w = ego.orientation_z, ego.orientation_w
        message.twist.twist.linear.x = ego.speed
        message.twist.twist.angular.z = ego.yaw_rate
        return message


def stamp_of_bytes(data: bytes) -> int:
    """Stamp [ns] of a serialized message that begins with a header."""
    seconds, nanoseconds = struct.unpack_from("<iI", data, _HEADER)
    return int(seconds) * 1_000_000_000 + int(nanoseconds)


def ego_of_bytes(data: bytes, length: float, width: float) -> EgoState:
    """The ego from a serialized odometry message (CDR, little endian); its size [m] comes from the route.

    Raises:
        ValueError: the bytes are cut short or big endian.
    """
    if len(data) < _HEADER or data[1] != 1:
        raise ValueError("odometry is not little-endian CDR")
    try:
        place = _after_text(data, _HEADER + 8)
        place = _after_text(data, place)
        place += (_HEADER - place) % 8
        x, y, _, _, _, orientation_z, orientation_w = _POSE.unpack_from(data, place)
        speed, _, _, _, _, yaw_rate = _TWIST.unpack_from(data, place + _POSE.size + _COVARIANCE)
    except struct.error as error:
        raise ValueError("odometry is cut short") from error
    return EgoState.from_quaternion(x, y, orientation_z, orientation_w, speed, yaw_rate, length, width)


def _after_text(data: bytes, place: int) -> int:
    """Where the field after a string begins, if it is not aligned more strictly than a string."""
    place += (_HEADER - place) % 4
    (size,) = struct.unpack_from("<I", data, place)
    return int(place + 4 + size)
