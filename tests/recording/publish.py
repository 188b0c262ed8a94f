"""Publishes numbered messages at full speed, from a process of its own.

Prints "connected" once a recorder listens to every topic, "published" when all is out, and ends when its input ends.
"""

import array
import sys
import time

import rclpy
from builtin_interfaces.msg import Time
from nav_msgs.msg import Odometry
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from roadmend_msgs.msg import Command, ObjectList, Route, ScenarioEvent
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Header, String, UInt8MultiArray

TICK_NS = 50_000_000
COUNT = int(sys.argv[1])
PACE = float(sys.argv[2])  # [s] pause between two ticks; 0 for full speed
OPTIONS = sys.argv[3:]  # how many messages a topic keeps, and "late": see the end of main
DEPTH = next((int(option) for option in OPTIONS if option.isdecimal()), 5000)
STREAM = QoSProfile(depth=DEPTH)  # keeps what the recorder has not acknowledged yet
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
EVENT = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
STREAMS = {
    "/clock": Clock,
    "ego": Odometry,
    "objects": ObjectList,
    "policy/command": Command,
    "text": String,
    "image": UInt8MultiArray,
}


def stamp(tick):
    return Time(sec=tick * TICK_NS // 10**9, nanosec=tick * TICK_NS % 10**9)


def message(kind, tick):
    header = Header(stamp=stamp(tick), frame_id="map")
    if kind is Clock:
        return Clock(clock=stamp(tick))
    if kind is String:
        return String(data=f"{tick} {time.time_ns()}")
    if kind is UInt8MultiArray:
        return UInt8MultiArray(data=array.array("B", tick.to_bytes(4, "little") * 500))
    if kind is ObjectList:
        return ObjectList(header=header, id=array.array("I", range(tick % 50)), x=array.array("d", [tick] * 20))
    return kind(header=header)


def main():
    rclpy.init()
    node = rclpy.create_node("publisher")
    route = node.create_publisher(Route, "route", LATCHED)
    route.publish(Route(header=Header(stamp=stamp(0)), scenario="merge"))  # before anyone can listen
    events = node.create_publisher(ScenarioEvent, "events", EVENT)
    wall = node.create_publisher(Command, "wall", STREAM)
    publishers = [(kind, node.create_publisher(kind, topic, STREAM)) for topic, kind in STREAMS.items()]
    everyone = [route, events, wall, *(publisher for _, publisher in publishers)]
    while any(publisher.get_subscription_count() == 0 for publisher in everyone):
        time.sleep(0.01)
    time.sleep(0.3)  # the other side must know of it as well
    print("connected", flush=True)
    events.publish(ScenarioEvent(header=Header(stamp=stamp(0)), kind=ScenarioEvent.STARTED, text="begin"))
    for tick in range(COUNT):
        for kind, publisher in publishers:
            publisher.publish(message(kind, tick))
        if PACE:
            time.sleep(PACE)
    now = time.time_ns()
    wall.publish(Command(header=Header(stamp=Time(sec=now // 10**9, nanosec=now % 10**9))))
    collision = ScenarioEvent(header=Header(stamp=stamp(COUNT)), kind=ScenarioEvent.COLLISION, text="hit bus_1")
    events.publish(collision)
    print("published", flush=True)
    if "late" in OPTIONS:  # a publisher that offers less than the first one did
        late = node.create_publisher(String, "text", QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT))
        while not late.get_subscription_count():  # until the recorder has subscribed to what it offers
            time.sleep(0.01)
        time.sleep(0.5)
        late.publish(String(data="late"))
        time.sleep(0.3)
        print("late", flush=True)
    sys.stdin.read()
    rclpy.try_shutdown()


if __name__ == "__main__":
    main()
