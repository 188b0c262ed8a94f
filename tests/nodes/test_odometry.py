import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from nav_msgs.msg import Odometry
from rclpy.serialization import deserialize_message, serialize_message

from roadmend.core.scene import EgoState
from roadmend.nodes.convert import ego_of, header_of, nanoseconds_of
from roadmend.nodes.odometry import OdometryWriter, ego_of_bytes, stamp_of_bytes

number = st.floats(-1e4, 1e4)


@settings(max_examples=60, deadline=None)
@given(number, number, st.floats(-math.pi, math.pi), st.floats(0, 60), st.floats(-2, 2), st.integers(0, 10**12))
def test_the_bytes_say_what_rclpy_says(x, y, yaw, speed, yaw_rate, stamp):
    ego = EgoState.from_yaw(x, y, yaw, speed, yaw_rate, 4.7, 1.85)
    data = serialize_message(OdometryWriter().fill(ego, header_of(stamp * 1e-9)))
    read = deserialize_message(data, Odometry)
    assert ego_of_bytes(data, 4.7, 1.85) == ego_of(read, 4.7, 1.85) == ego
    assert stamp_of_bytes(data) == nanoseconds_of(read.header.stamp)


@pytest.mark.parametrize("frame", ["", "m", "map", "odom_of_somebody_else"])
@pytest.mark.parametrize("child", ["", "base_link", "b"])
def test_whatever_the_frames_are_called(frame, child):
    message = OdometryWriter().fill(EgoState.from_yaw(1.0, 2.0, 0.5, 3.0, 0.1, 4.7, 1.85), header_of(1.5, frame))
    message.child_frame_id = child
    assert ego_of_bytes(serialize_message(message), 4.7, 1.85).x == 1.0
    assert ego_of_bytes(serialize_message(message), 4.7, 1.85).yaw_rate == 0.1


@pytest.mark.parametrize(
    "data", [b"", b"\x00\x01\x00\x00", b"\x00\x00\x00\x00" + bytes(700), b"\x00\x01\x00\x00" + b"\xff" * 40]
)
def test_other_bytes_are_refused(data):
    with pytest.raises(ValueError, match="odometry"):
        ego_of_bytes(data, 4.7, 1.85)
