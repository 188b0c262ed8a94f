"""A subscription that tells the numbers of messages; what its listener raises comes out of the executor."""

import time

import pytest
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.experimental import EventsExecutor
from roadmend_msgs.msg import Command

from roadmend.nodes import qos
from roadmend.nodes.inputs import COMMAND
from roadmend.nodes.numbered_input import NumberedInput
from roadmend.recording import topics


@pytest.mark.parametrize("kind", [EventsExecutor, SingleThreadedExecutor])
def test_what_its_listener_raises_comes_out_of_the_executor(node, kind):
    def fail(data, number):
        raise ZeroDivisionError("of the listener")

    reader, writer = node("reader"), node("writer")
    executor = kind(context=reader.context)
    executor.add_node(reader)
    NumberedInput(reader, COMMAND, Command, fail)
    publisher = writer.create_publisher(Command, topics.POLICY_COMMAND, qos.COMMAND)

    def spin():
        deadline = time.monotonic() + 20.0
        while time.monotonic() < deadline:
            publisher.publish(Command())
            executor.spin_until_future_complete(rclpy.Future(), timeout_sec=0.05)

    try:
        with pytest.raises(ZeroDivisionError, match="of the listener"):
            spin()
    finally:
        executor.shutdown()
