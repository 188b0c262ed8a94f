r"""A stack of its own, with no simulator in it: a car that drives into one that stands, unless someone repairs it.

Publishes what such a stack has: odometry, detections without a speed, and the acceleration that its controller asks
for, each at its own rate. The car moves by what it is told on /drive/repaired. In another terminal:

    ./roadmend repair --repair rss --ego /odom --objects /detections --objects-type vision_msgs/msg/Detection3DArray \
        --command /drive/accel --command-type geometry_msgs/msg/AccelStamped --repaired /drive/repaired

and then ``ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST .venv/bin/python src/examples/own_graph.py``. With ``--bare`` the car
obeys its own controller instead.
"""

import contextlib
import sys

import rclpy
from geometry_msgs.msg import AccelStamped
from nav_msgs.msg import Odometry
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from vision_msgs.msg import Detection3D, Detection3DArray

START, SPEED, STANDS_AT = 0.0, 12.0, 90.0  # [m], [m/s], [m]
LENGTH = 4.8  # [m] of both cars
STEP = 0.02  # [s]
TIME_MAX = 30.0  # [s]
PATIENCE = 5.0  # [s] until it is said that nobody answers


class Stack(Node):
    """Vehicle, detector and controller in one node."""

    def __init__(self, *, bare: bool) -> None:
        super().__init__("own_stack")
        self.x, self.speed, self.wanted, self.time = START, SPEED, 0.0, 0.0
        self.is_told = bare  # the clock stands until somebody answers
        self.bare = bare
        self.is_answered = bare
        self.result = ""
        self.to_ego = self.create_publisher(Odometry, "odom", 10)
        self.to_objects = self.create_publisher(Detection3DArray, "detections", qos_profile_sensor_data)
        self.to_vehicle = self.create_publisher(AccelStamped, "drive/accel", 10)
        self.create_subscription(AccelStamped, "drive/repaired", self.obey, 10)
        self.create_timer(STEP, self.move)
        self.create_timer(0.1, self.detect)
        self.create_timer(0.05, self.control)
        self.patience = self.create_timer(PATIENCE, self.complain)

    def stamped(self, message: object, frame: str) -> object:
        """The message at the present time."""
        message.header.stamp = self.get_clock().now().to_msg()
        message.header.frame_id = frame
        return message

    def move(self) -> None:
        """The vehicle: drives, and tells where it is."""
        if self.is_told:
            self.time += STEP
            self.speed = max(0.0, self.speed + self.wanted * STEP)
            self.x += self.speed * STEP
        odometry = self.stamped(Odometry(child_frame_id="base_link"), "odom")
        odometry.pose.pose.position.x = self.x
        odometry.twist.twist.linear.x = self.speed
        self.to_ego.publish(odometry)
        gap = STANDS_AT - self.x - LENGTH
        if gap <= 0.0:
            self.result = f"collided at {self.speed:.1f} m/s"
        elif self.time > 1.0 and self.speed == 0.0:
            self.result = f"stopped {gap:.1f} m before it"
        elif self.time > TIME_MAX:
            self.result = "did neither collide nor stop"

    def detect(self) -> None:
        """The detector: one box, in the frame that moves with the car."""
        one = Detection3D(id="car_1")
        one.bbox.center.position.x = STANDS_AT - self.x
        one.bbox.size.x, one.bbox.size.y, one.bbox.size.z = LENGTH, 1.8, 1.5
        self.to_objects.publish(self.stamped(Detection3DArray(detections=[one]), "base_link"))

    def control(self) -> None:
        """The controller: keeps its speed and looks at nobody."""
        command = self.stamped(AccelStamped(), "base_link")
        command.accel.linear.x = 0.8 * (SPEED - self.speed)
        self.to_vehicle.publish(command)
        if self.bare:
            self.wanted = command.accel.linear.x

    def obey(self, command: AccelStamped) -> None:
        """What repair made of the controller's wish."""
        self.is_answered = True
        if not self.bare:
            # A stop before anything has been seen is no answer yet: the car is not let go before repair sees.
            self.is_told = self.is_told or command.accel.linear.x > -1.0
            self.wanted = command.accel.linear.x

    def complain(self) -> None:
        """Say once that nobody has answered."""
        self.patience.cancel()
        if not self.is_answered:
            mend = "start './roadmend repair' as its first lines say, with the same ROS_DOMAIN_ID and ROS_AUTOMATIC_DISCOVERY_RANGE"
            print(f"own_graph: no answer on /drive/repaired for {PATIENCE:g} s; {mend}", file=sys.stderr, flush=True)


def main() -> int:
    """Drive until the end; 1 after a collision."""
    rclpy.init()
    stack = Stack(bare="--bare" in sys.argv)
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        while not stack.result:
            rclpy.spin_once(stack, timeout_sec=0.5)
    print(stack.result or "interrupted", flush=True)
    rclpy.try_shutdown()
    return int(stack.result.startswith("collided") or not stack.result)


if __name__ == "__main__":
    sys.exit(main())
