"""A node that publishes a number of messages at full speed, once a recorder listens, and is finished then."""

import sys
import time

from rclpy.node import Node
from rclpy.qos import QoSProfile
from std_msgs.msg import String

from roadmend.nodes.spinning import run_node

COUNT = int(sys.argv[1])


class Leaver(Node):
    linger = 30.0  # [s] a starved process is not what is tested

    def __init__(self):
        super().__init__("leaver_node")
        self.finished = False
        self._publisher = self.create_publisher(String, "text", QoSProfile(depth=COUNT))
        self._listened = 0.0
        self.create_timer(0.05, self._look)

    def _look(self):
        if not self._listened and self._publisher.get_subscription_count():
            self._listened = time.monotonic()
        if self._listened and time.monotonic() - self._listened > 0.5:  # the other side must know of it as well
            print("connected", flush=True)
            sys.stdin.readline()
            for number in range(COUNT):
                self._publisher.publish(String(data=f"{number}"))
            print("published", flush=True)
            self.finished = True


if __name__ == "__main__":
    sys.exit(run_node(Leaver, ["leaver_node"]))
