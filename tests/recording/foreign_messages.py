"""Messages and bags of another stack, made without ROS."""

import math

from roadmend.recording import messages
from roadmend.recording.codec import MessageType, encode, type_of
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
from roadmend.recording.qos import Qos
from roadmend.recording.writer import BagWriter

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


def record(folder, stands_at=60.0, objects_until=9.0, begin=100.0, repaired=lambda step: None, stamped=True):
    """5 s at 10 m/s toward one who stands: odometry at 50 Hz, detections at 10 Hz, commands at 20 Hz.

    Commands that are not ``stamped`` arrive 2 ms later, and what was done has the odometry's stamp and log time.
    """
    streams = []
    for step in range(500):
        after = 0.01 * step
        time, x = begin + after, 10.0 * after
        if step % 2 == 0:
            streams.append(("/odom", time, odometry(time, x=x)))
        if step % 10 == 0 and after < objects_until:
            one = detection("7", stands_at - x, 0.0)
            streams.append(("/detections", time, detections(time, one, frame="base_link")))
        if step % 5 == 0:
            seen = begin + 0.01 * (step - step % 2)
            told = time if stamped else seen
            if (repair := repaired(step)) is not None:
                state = messages.repair_message_of(repair, "rss", messages.header_of(told))
                streams.append(("/repair/state", told + 0.001, state))
            arrives = time if stamped else time + 0.002
            streams.append(("/drive/accel", arrives, acceleration(time if stamped else 0.0, 0.5)))
    streams.sort(key=lambda stream: stream[1])
    with BagWriter(folder) as writer:
        for topic, kind in {topic: type_of(message) for topic, _, message in streams}.items():
            writer.add_topic(topic, kind, [Qos()])
        for topic, time, message in streams:
            writer.write(topic, round(time * 1e9), encode(message))
    return folder
