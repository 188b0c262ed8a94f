"""repair_node beside another stack: real DDS within this process, at the rates and with the QoS of others."""

import json
import time

import pytest
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import AccelStamped
from nav_msgs.msg import Odometry
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from roadmend_msgs.msg import Command, ObjectList, RepairState
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String
from vision_msgs.msg import Detection3D, Detection3DArray

from roadmend.core.errors import InputError
from roadmend.nodes import foreign_inputs
from roadmend.nodes.diagnostics import Level
from roadmend.nodes.repair import RepairNode
from roadmend.recording.foreign_commands import AccelerationForm
from roadmend.recording.foreign_objects import Detections

PATIENCE_S = 60.0
BEST_EFFORT = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
TYPES = {"objects_type": Detections.type_name, "command_type": AccelerationForm.type_name}
REMAPPED = {"ego": "/odom", "objects": "/seen", "policy/command": "/drive/accel", "repair/command": "/drive/repaired"}


class Stack:
    """Another stack, and the repair node beside it, in one executor."""

    def __init__(self, domain, **parameters):
        given = {"inputs": "newest", "input_timeout": 5.0, **parameters}
        words = [word for name, value in given.items() for word in ("-p", f"{name}:={json.dumps(value)}")]
        words += [word for pair in REMAPPED.items() for word in ("-r", ":=".join(pair))]
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=domain)
        rclpy.init(args=["test", "--ros-args", *words], domain_id=domain)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.node = rclpy.create_node("stack", namespace="other", context=self.context)
        self.executor.add_node(self.node)
        self.states, self.commands = [], []
        self.node.create_subscription(RepairState, "/repair/state", self.states.append, 10)
        self.repair = RepairNode()
        self.repair_executor = SingleThreadedExecutor()
        self.repair_executor.add_node(self.repair)
        self.publishers = {}

    def spin(self, duration=0.05):
        end = time.monotonic() + duration
        while time.monotonic() < end:
            self.executor.spin_once(timeout_sec=0.005)
            self.repair_executor.spin_once(timeout_sec=0.005)

    def publish(self, topic, message, profile=10):
        if topic not in self.publishers:
            self.publishers[topic] = self.node.create_publisher(type(message), topic, profile)
        if hasattr(message, "header"):
            message.header.stamp = self.node.get_clock().now().to_msg()
        self.publishers[topic].publish(message)

    def ego(self, speed=10.0):
        message = Odometry(child_frame_id="base_link")
        message.header.frame_id = "odom"
        message.twist.twist.linear.x = speed
        self.publish("/odom", message, BEST_EFFORT)

    def objects(self, ahead=15.0):
        one = Detection3D(id="4")
        one.bbox.center.position.x = ahead
        one.bbox.size.x, one.bbox.size.y = 4.5, 1.8
        message = Detection3DArray(detections=[one])
        message.header.frame_id = "base_link"
        self.publish("/seen", message, BEST_EFFORT)

    def command(self, wanted=1.0):
        message = AccelStamped()
        message.accel.linear.x, message.accel.angular.z = wanted, 0.25
        self.publish("/drive/accel", message)

    def until(self, test, *sends):
        """Send and spin until the test holds."""
        end = time.monotonic() + PATIENCE_S
        while not test():
            assert time.monotonic() < end, [state.reason for state in self.states[-3:]]
            for send in sends:
                send()
            self.spin()

    def close(self):
        self.repair_executor.shutdown()
        self.executor.shutdown()
        self.repair.destroy_node()
        self.node.destroy_node()
        rclpy.try_shutdown()
        self.context.try_shutdown()


@pytest.fixture
def stack(domain, tmp_path, monkeypatch):
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path))
    made = []

    def make(**parameters):
        made.append(Stack(domain, **parameters))
        return made[-1]

    yield make
    for one in made:
        one.close()


def test_it_brakes_for_who_is_ahead_and_hands_the_rest_of_the_command_on(stack):
    one = stack(**TYPES)
    one.node.create_subscription(AccelStamped, "/drive/repaired", one.commands.append, 10)
    one.until(
        lambda: any(state.state == RepairState.REPAIRED for state in one.states) and one.commands,
        one.ego,
        one.objects,
        one.command,
    )
    state = next(state for state in one.states if state.state == RepairState.REPAIRED)
    assert list(state.trigger_id) == [4]
    assert state.final_action < 0.0 < state.policy_action
    assert "no planned trajectory: the present speed and turn are assumed" in state.reason
    one.until(lambda: one.commands[-1].accel.linear.x < 0.0, one.ego, one.objects, one.command)
    assert one.commands[-1].accel.angular.z == 0.25
    health = one.repair._health()
    assert health.level == Level.OK
    assert health.values["trajectory"].startswith("no planned trajectory")


def test_commands_alone_are_held_and_what_is_missing_is_named_with_topic_type_and_remedy(stack, capfd, monkeypatch):
    monkeypatch.setattr(foreign_inputs, "NAMED_AFTER_S", 0.2)
    one = stack(**TYPES)
    one.publish("/elsewhere", Detection3DArray())
    one.until(lambda: one.states, one.command)
    assert {state.state for state in one.states} == {RepairState.STARTING}
    assert all(state.final_action == -0.5 for state in one.states)
    health = one.repair._health()
    assert health.level == Level.ERROR
    assert health.message.startswith("missing ego, objects")
    assert health.values["missing ego"].startswith(
        "/odom (nav_msgs/msg/Odometry, any QoS): nobody publishes it in ROS_"
    )
    assert "but vision_msgs/msg/Detection3DArray on /elsewhere" in health.values["missing objects"]
    assert health.values["missing objects"].endswith("-r objects:=/elsewhere")
    said = ""
    end = time.monotonic() + PATIENCE_S
    while "waits for /seen" not in said and time.monotonic() < end:
        one.spin(0.2)
        said += capfd.readouterr().err
    assert "waits for /odom (nav_msgs/msg/Odometry, any QoS)" in said
    assert "waits for /seen (vision_msgs/msg/Detection3DArray, any QoS)" in said


def test_a_wrong_type_is_named_with_its_publisher_and_the_parameter_that_fits(stack):
    one = stack(command_type=AccelerationForm.type_name)
    one.publish("/seen", Detection3DArray())
    one.publish("/odom", String())
    for part in ("objects", "ego"):
        one.until(lambda part=part: "/other/stack" in one.repair._health().values[f"missing {part}"])
    missing = one.repair._health().values
    assert "/other/stack publishes vision_msgs/msg/Detection3DArray there" in missing["missing objects"]
    assert missing["missing objects"].endswith("-p objects_type:=vision_msgs/msg/Detection3DArray")
    assert "/other/stack publishes std_msgs/msg/String there" in missing["missing ego"]


def test_publishers_of_any_qos_are_heard_and_one_that_comes_later_with_less_is_too(stack):
    one = stack()
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    message = ObjectList()
    message.header.frame_id = "odom"
    one.until(
        lambda: "objects" not in one.repair._foreign.missing(),
        one.ego,
        lambda: one.publish("/seen", message, latched),
    )
    one.node.destroy_publisher(one.publishers.pop("/seen"))
    one.until(lambda: "objects" in one.repair._foreign.missing(), one.ego)
    one.until(
        lambda: "objects" not in one.repair._foreign.missing(),
        one.ego,
        lambda: one.publish("/seen", message, BEST_EFFORT),
    )


def test_a_command_that_ends_is_replaced_by_stops(stack):
    one = stack(input_timeout=1.0, **TYPES)
    one.until(lambda: any(state.state == RepairState.PASS for state in one.states), one.ego, far(one), one.command)
    one.until(lambda: one.states[-1].state == RepairState.STALE_COMMAND, one.ego, far(one))
    count = len(one.states)
    one.until(lambda: len(one.states) > count + 2, one.ego, far(one))
    assert "no command for" in one.states[-1].reason
    one.until(lambda: one.states[-1].state == RepairState.PASS, one.ego, far(one), one.command)


def test_a_vehicle_that_brakes_less_presses_its_brake_further_for_the_same_stop(stack):
    one = stack(input_timeout=1.0, full_brake=6.0, **TYPES)
    one.node.create_subscription(AccelStamped, "/drive/repaired", one.commands.append, 10)
    one.until(lambda: one.commands and one.commands[-1].accel.linear.x == 1.0, one.ego, far(one), one.command)
    one.until(lambda: one.commands[-1].accel.linear.x != 1.0, one.ego, far(one))
    assert one.commands[-1].accel.linear.x == pytest.approx(-4.0)
    assert one.states[-1].state == RepairState.STALE_COMMAND
    one.until(lambda: one.states[-1].state == RepairState.REPAIRED, one.ego, one.objects, one.command)
    one.until(lambda: one.commands[-1].accel.linear.x < -4.01, one.ego, one.objects, one.command)
    assert one.commands[-1].accel.linear.x <= -5.0 + 1e-9


def test_while_the_clock_stands_stops_and_diagnostics_go_on_by_its_time(stack):
    one = stack(input_timeout=1.0, use_sim_time=True, **TYPES)
    health = []
    one.node.create_subscription(DiagnosticArray, "/diagnostics", health.append, 10)
    clock = Clock()
    clock.clock.sec = 2_000_000_000  # later than the stamps of the commands
    one.until(lambda: one.repair.get_clock().now().nanoseconds, lambda: one.publish("/clock", clock))
    one.until(lambda: any(state.state == RepairState.PASS for state in one.states), one.ego, far(one), one.command)
    one.until(lambda: one.states[-1].state == RepairState.STALE_COMMAND, one.ego, far(one))
    count, told = len(one.states), len(health)
    one.until(lambda: len(one.states) > count + 2 and len(health) > told + 1, one.ego, far(one))
    assert all(state.header.stamp == clock.clock for state in one.states[count:])


def far(stack):
    return lambda: stack.objects(ahead=400.0)


def test_inactive_it_sends_nothing_and_another_method_takes_over_while_it_runs(stack):
    one = stack(**TYPES)
    one.until(lambda: one.states, one.ego, one.objects, one.command)
    one.repair.trigger_deactivate()
    one.spin(0.5)
    count = len(one.states)
    for _ in range(10):
        one.ego()
        one.objects()
        one.command()
        one.spin()
    assert len(one.states) == count
    one.repair.trigger_activate()
    one.until(lambda: len(one.states) > count, one.ego, one.objects, one.command)


def test_a_type_that_cannot_be_read_is_one_line(domain, tmp_path, monkeypatch):
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path))
    rclpy.init(
        args=["test", "--ros-args", "-p", "inputs:=newest", "-p", "objects_type:=std_msgs/msg/String"], domain_id=domain
    )
    try:
        with pytest.raises(
            InputError, match=r"^parameter objects_type: 'std_msgs/msg/String' cannot be read here; choose"
        ):
            RepairNode()
    finally:
        rclpy.try_shutdown()


def test_our_own_types_need_no_parameter(stack):
    one = stack()
    one.node.create_subscription(Command, "/drive/repaired", one.commands.append, 10)
    message = ObjectList()
    message.header.frame_id = "odom"
    one.until(
        lambda: any(state.state == RepairState.PASS for state in one.states) and one.commands,
        one.ego,
        lambda: one.publish("/seen", message),
        lambda: one.publish("/drive/accel", Command(throttle=0.3)),
    )
    one.until(
        lambda: one.commands[-1].throttle == 0.3,
        one.ego,
        lambda: one.publish("/seen", message),
        lambda: one.publish("/drive/accel", Command(throttle=0.3)),
    )


def test_a_second_publisher_is_named(stack, capfd):
    one = stack(**TYPES)
    other = rclpy.create_node("joystick", context=one.context)
    try:
        other.create_publisher(AccelStamped, "/drive/accel", 10)
        said = "/drive/accel is published by /joystick, /other/stack; let one of them do it"
        one.until(lambda: one.repair._health().message == said, one.ego, one.objects, one.command)
        assert one.repair._health().level == Level.WARN
        heard: list[str] = []

        def is_said() -> bool:
            heard.append(capfd.readouterr().err)
            return said in "".join(heard)

        one.until(is_said, one.ego, one.objects, one.command)
    finally:
        other.destroy_node()


@pytest.mark.parametrize("inputs", ["newest", "paired"])
def test_a_node_that_would_hear_its_own_answers_as_commands_is_refused(domain, tmp_path, monkeypatch, inputs):
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path))
    words = ("-p", f"inputs:={inputs}", "-r", "__ns:=/car", "-r", "policy/command:=repair/command")
    rclpy.init(args=["test", "--ros-args", *words], domain_id=domain)
    try:
        with pytest.raises(
            InputError, match="/car/repair/command: is the topic of the policy's commands and of the rep"
        ):
            RepairNode()
    finally:
        rclpy.try_shutdown()
