"""Writes an episode that no graph drove into a bag, message by message as the graph's nodes would have sent it."""

from typing import Any

from rclpy.qos import QoSProfile
from rclpy.serialization import deserialize_message
from roadmend_msgs import msg
from rosgraph_msgs.msg import Clock

from roadmend.core.command import Command, Decision, Trajectory
from roadmend.core.outcome import Event
from roadmend.core.repair import Repair
from roadmend.core.route import Route
from roadmend.core.scene import Scene
from roadmend.nodes import convert, qos
from roadmend.nodes.drawing import MARKERS_MAP, draw_tick
from roadmend.nodes.marker_map import map_markers
from roadmend.nodes.odometry import OdometryWriter
from roadmend.nodes.qos import offer_from
from roadmend.recording.encoder import Encoder
from roadmend.recording.writer import BagWriter


class EpisodeWriter:
    """Writes core types as messages; their log time is the time of their tick, as the recorder has it.

    Args:
        writer: the bag.
        namespace: before every topic but the clock; empty or with a leading "/".
    """

    def __init__(self, writer: BagWriter, namespace: str = "") -> None:
        self._writer = writer
        self._namespace = namespace
        self._encoder = Encoder()
        self._known: set[str] = set()
        self._odometry = OdometryWriter()

    def route(self, route: Route, map_data: bytes | None) -> None:
        """The ego's route, the serialized map if there is one, and a drawing of both, at the beginning."""
        header = convert.header_of(0.0)
        lanes = None if map_data is None else deserialize_message(map_data, msg.Map)
        self.put(qos.ROUTE, 0.0, convert.route_message_of(route, header), qos.LATCHED)
        if lanes is not None:
            self.put(qos.MAP, 0.0, lanes, qos.LATCHED)
        self.put(MARKERS_MAP, 0.0, map_markers(lanes, route, header), qos.LATCHED)

    def scene(self, scene: Scene) -> None:
        """What there is to see at a tick, and its time."""
        header = convert.header_of(scene.time)
        self.put(qos.CLOCK, scene.time, Clock(clock=header.stamp), qos.STREAM)
        self.put(qos.EGO, scene.time, self._odometry.fill(scene.ego, header), qos.STREAM)
        objects = convert.object_message_of(scene.objects, scene.signals, header)
        self.put(qos.OBJECTS, scene.time, objects, qos.STREAM)

    def decision(self, time: float, decision: Decision) -> None:
        """What the policy decided at ``time`` [s]."""
        header = convert.header_of(time)
        trajectory = convert.trajectory_message_of(decision.trajectory, header)
        self.put(qos.POLICY_TRAJECTORY, time, trajectory, qos.STREAM)
        self._command(qos.POLICY_COMMAND, time, decision.command)

    def repair(self, time: float, repair: Repair, method: str) -> None:
        """What a repair method answered at ``time`` [s]."""
        self._command(qos.REPAIR_COMMAND, time, repair.command)
        state = convert.repair_message_of(repair, method, convert.header_of(time))
        self.put(qos.REPAIR_STATE, time, state, qos.STREAM)

    def event(self, event: Event) -> None:
        """Something that happened to the episode."""
        self.put(qos.EVENTS, event.time, convert.event_message_of(event), qos.EVENT)

    def drawing(
        self, scene: Scene, route: Route, decision: Decision | None = None, repair: Repair | None = None
    ) -> None:
        """What viz_node would draw of a tick."""
        header = convert.header_of(scene.time)
        plan = Trajectory.empty() if decision is None else decision.trajectory
        state = None if repair is None else convert.repair_message_of(repair, "", header)
        for topic, message in draw_tick(scene, plan, state, route, header):
            self.put(topic, scene.time, message, qos.STREAM)

    def put(self, topic: str, time: float, message: Any, profile: QoSProfile) -> None:
        """Write any message.

        Args:
            topic: its topic, relative unless it begins with "/".
            time: of its tick [s].
            message: of a ROS type.
            profile: what its publisher in the graph offers.
        """
        name = topic if topic.startswith("/") else f"{self._namespace}/{topic}"
        kind = type(message)
        type_name = f"{kind.__module__.split('.')[0]}/msg/{kind.__name__}"
        if name not in self._known:
            self._known.add(name)
            self._writer.add_topic(name, type_name, [offer_from(profile)])
        time_ns = convert.nanoseconds_of(convert.stamp_of(time))
        self._writer.write(name, time_ns, self._encoder.encode(type_name, message))

    def _command(self, topic: str, time: float, command: Command) -> None:
        message = convert.command_message_of(command, convert.header_of(time))
        self.put(topic, time, message, qos.COMMAND)
