"""A driving policy as a ROS node of one's own; it needs the messages of roadmend and nothing else of it.

ROS_DOMAIN_ID=42 ./roadmend run --scenario config/scenarios/demo-exit.yaml --policy external --repair adreft
ROS_DOMAIN_ID=42 ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST .venv/bin/python src/examples/external_policy.py
"""

import contextlib

import rclpy
from nav_msgs.msg import Odometry
from rclpy.duration import Duration
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import QoSProfile
from roadmend_msgs.msg import Command

PACE = 12.0  # [m/s]


class EvenPace(Node):
    """Pushes below the pace and brakes above it, whoever is ahead; changes lanes as soon as the route wants it."""

    def __init__(self) -> None:
        super().__init__("even_pace")
        promise = QoSProfile(depth=1, deadline=Duration(seconds=0.5))  # what the repair asks of a command's publisher
        self._commands = self.create_publisher(Command, "policy/command", promise)
        self.create_subscription(Odometry, "ego", self._on_ego, 10)

    def _on_ego(self, ego: Odometry) -> None:
        action = min(max(0.5 * (PACE - ego.twist.twist.linear.x), -1.0), 1.0)
        command = Command(header=ego.header, change_lane=True)  # the tick's stamp says which tick it is for
        command.throttle, command.brake = max(action, 0.0), max(-action, 0.0)
        self._commands.publish(command)


if __name__ == "__main__":
    rclpy.init()
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(EvenPace())
