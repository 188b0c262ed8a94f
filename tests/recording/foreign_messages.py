"""Messages of another stack, made without ROS."""

import math

from roadmend.recording.codec import MessageType
from roadmend.recording.messages import (
    EGO,
    HEADER,
    NANOSECONDS,
    POINT,
    POSE,
    POSE_WITH_COVARIANCE,
    QUATERNION,
    TWIST,
    TWIST_WITH_COVARIANCE,
    VECTOR,
    stamp_message_of,
)

DETECTIONS = MessageType("vision_msgs/msg/Detection3DArray")
DETECTION = MessageType("vision_msgs/msg/Detection3D")
BOX = MessageType("vision_msgs/msg/BoundingBox3D")
RESULT = MessageType("vision_msgs/msg/ObjectHypothesisWithPose")
HYPOTHESIS = MessageType("vision_msgs/msg/ObjectHypothesis")
ACCELERATION = MessageType("geometry_msgs/msg/AccelStamped")
ACCEL = MessageType("geometry_msgs/msg/Accel")


def header(time, frame="odom"):
    return HEADER(stamp=stamp_message_of(round(time * NANOSECONDS)), frame_id=frame)


def turned(yaw):
    return QUATERNION(z=math.sin(0.5 * yaw), w=math.cos(0.5 * yaw))


def odometry(time, x=0.0, y=0.0, yaw=0.0, speed=10.0, yaw_rate=0.0, frame="odom"):
    return EGO(
        header=header(time, frame),
        child_frame_id="base_link",
        pose=POSE_WITH_COVARIANCE(pose=POSE(position=POINT(x=x, y=y), orientation=turned(yaw))),
        twist=TWIST_WITH_COVARIANCE(twist=TWIST(linear=VECTOR(x=speed), angular=VECTOR(z=yaw_rate))),
    )


def detection(name, x, y, yaw=0.0, length=4.5, width=1.8, kinds=(("car", 0.9),)):
    return DETECTION(
        id=name,
        results=[RESULT(hypothesis=HYPOTHESIS(class_id=kind, score=score)) for kind, score in kinds],
        bbox=BOX(center=POSE(position=POINT(x=x, y=y), orientation=turned(yaw)), size=VECTOR(x=length, y=width, z=1.5)),
    )


def detections(time, *those, frame="odom"):
    return DETECTIONS(header=header(time, frame), detections=list(those))


def acceleration(time, wanted, lateral=0.0, turn=0.0):
    accel = ACCEL(linear=VECTOR(x=wanted, y=lateral), angular=VECTOR(z=turn))
    return ACCELERATION(header=header(time, "base_link"), accel=accel)
