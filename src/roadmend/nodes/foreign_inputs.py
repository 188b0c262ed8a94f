"""The inputs of repair in a graph that is not ours: found on their topics, asked for as they are offered, named if missing."""

import os
import time
from collections.abc import Callable
from typing import Any

from nav_msgs.msg import Odometry
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.qos import QoSProfile
from roadmend_msgs import msg

from roadmend.core.errors import InputError
from roadmend.nodes.discovery import look_up, request_for
from roadmend.recording import foreign_repair, messages, topics
from roadmend.recording.codec import MessageType
from roadmend.recording.foreign_commands import COMMAND_FORMS
from roadmend.recording.foreign_objects import OBJECT_READERS
from roadmend.recording.foreign_parameters import ForeignParameters
from roadmend.recording.foreign_repair import Answer, ForeignRepair
from roadmend.repair.guard import GuardedRepairer

DISCOVERY_PERIOD_S = 0.2  # [s] of wall time between two looks at the graph
WATCH_PERIOD_S = 0.01  # [s] between two looks at the ages of what has arrived
REPEAT_S = 0.05  # [s] between two stop commands while the command is late
NAMED_AFTER_S = 2.0  # [s] after which people are told what is missing
DEPTH = 5  # messages of a topic that may wait for this node


class _Input:
    """One topic that is wanted."""

    def __init__(self, topic: str, type_name: str, kind: Any, take: Callable[[bytes], None]) -> None:
        self.topic, self.type_name, self.kind, self.take = topic, type_name, kind, take
        self.request: QoSProfile | None = None
        self.subscription: Any = None
        self.late_since = 0.0  # [s] wall time


class ForeignInputs:
    """Subscribes to each input as its publishers offer it, and hands what has to be answered to the node.

    Args:
        node: the node; topics and remappings are its.
        settings: types of the messages and the vehicle's size.
        patience: [s] of wall time after which an input counts as late.
        send: called with each answer.

    Raises:
        InputError: a type of message is not known here, or not installed.
    """

    def __init__(
        self, node: Node, settings: ForeignParameters, patience: float, send: Callable[[Answer], None]
    ) -> None:
        reader = _find("objects_type", settings.objects_type, OBJECT_READERS)()
        self._form = _find("command_type", settings.command_type, COMMAND_FORMS)(settings.pedals)
        self._node, self._send = node, send
        self._repair = ForeignRepair(settings.outline, reader, self._form, patience)
        self.command_kind = look_up("command_type", [settings.command_type])[1]
        objects, objects_kind = MessageType(reader.type_name), look_up("objects_type", [reader.type_name])[1]
        take = self._repair
        self._inputs = {
            foreign_repair.EGO: _Input(
                topics.EGO, messages.EGO.name, Odometry, self._taker(messages.EGO.decode, take.take_ego)
            ),
            foreign_repair.OBJECTS: _Input(
                topics.OBJECTS, reader.type_name, objects_kind, self._taker(objects.decode, take.take_objects)
            ),
            foreign_repair.COMMAND: _Input(
                topics.POLICY_COMMAND, self._form.type_name, self.command_kind, self._on_command
            ),
            foreign_repair.TRAJECTORY: _Input(
                topics.POLICY_TRAJECTORY,
                messages.TRAJECTORY.name,
                msg.Trajectory,
                self._taker(messages.TRAJECTORY.decode, take.take_trajectory),
            ),
            foreign_repair.ROUTE: _Input(
                topics.ROUTE,
                messages.ROUTE.name,
                msg.Route,
                self._taker(messages.ROUTE.decode, lambda message, _now: take.take_route(message)),
            ),
        }
        self._begun = time.monotonic()
        self._last_stop = 0.0  # [s] wall time
        self._crowd: dict[str, str] = {}  # input -> several publishers, as people were told
        self._told: dict[str, str] = {}  # input -> what people were told of it
        wall = Clock(clock_type=ClockType.STEADY_TIME)
        node.create_timer(DISCOVERY_PERIOD_S, self._discover, clock=wall)
        node.create_timer(WATCH_PERIOD_S, self._watch, clock=wall)
        self._discover()

    def use(self, repairer: GuardedRepairer) -> None:
        """Repair with this from now on."""
        self._repair.use(repairer)

    @property
    def assumption(self) -> str:
        """What is assumed for want of a planned trajectory; empty where there is one."""
        return self._repair.assumption

    def missing(self) -> dict[str, str]:
        """The inputs that are late, each with its topic, type and QoS, and what to do about it."""
        return {part: self._explain(part, why) for part, why in self._repair.silent(time.monotonic()).items()}

    def crowded(self) -> dict[str, str]:
        """The needed inputs that several nodes publish, of which any may be the newest, and who they are."""
        found = {}
        for part in foreign_repair.NEEDED:
            one = self._inputs[part]
            infos = self._node.get_publishers_info_by_topic(one.topic)
            names = sorted({_name_of(info) for info in infos if info.topic_type == one.type_name})
            if len(infos) > 1 and len(names) > 1:
                topic = self._node.resolve_topic_name(one.topic)
                found[part] = f"{topic} is published by {', '.join(names)}; let one of them do it"
        return found

    # -- messages -----------------------------------------------------------------------------------------------------

    def _taker(self, decode: Callable[[bytes], Any], take: Callable[[Any, float], None]) -> Callable[[bytes], None]:
        def taken(data: bytes) -> None:
            try:
                take(decode(data), time.monotonic())
            except ValueError as error:  # bytes that are no such message: as if it had not come
                self._node.get_logger().error(f"unusable: {error}", throttle_duration_sec=1.0)

        return taken

    def _on_command(self, data: bytes) -> None:
        try:
            answer = self._repair.take_command(self._form.decode(data), time.monotonic())
        except ValueError as error:
            self._node.get_logger().error(f"unusable: {error}", throttle_duration_sec=1.0)
            return
        if answer is not None:
            self._send(answer)

    def _watch(self) -> None:
        now = time.monotonic()
        if now - self._last_stop < REPEAT_S:
            return
        is_simulated = self._node.get_parameter("use_sim_time").value
        answer = self._repair.overdue(now, self._node.get_clock().now().nanoseconds if is_simulated else None)
        if answer is not None:
            self._last_stop = now
            self._send(answer)

    # -- the graph ----------------------------------------------------------------------------------------------------

    def _discover(self) -> None:
        for one in self._inputs.values():
            infos = self._node.get_publishers_info_by_topic(one.topic)
            offers = [info.qos_profile for info in infos if info.topic_type == one.type_name]
            if not offers:
                continue
            request = request_for(offers, DEPTH)
            if one.request == request:
                continue
            if one.subscription is not None:
                self._node.destroy_subscription(one.subscription)
            one.late_since = 0.0  # what comes now is waited for anew before anything is said of it
            one.request = request
            one.subscription = self._node.create_subscription(one.kind, one.topic, one.take, request, raw=True)
        self._tell()

    def _tell(self) -> None:
        """Say what has been missing for a while, each thing once, and that it is there again."""
        now = time.monotonic()
        late = self._repair.silent(now)
        for part, one in self._inputs.items():
            if part not in late:
                one.late_since = 0.0
                if self._told.pop(part, None) is not None:
                    self._node.get_logger().info(f"{self._node.resolve_topic_name(one.topic)} arrives")
                continue
            one.late_since = one.late_since or now
            if now - one.late_since < NAMED_AFTER_S:
                continue
            told = self._explain(part, late[part])
            if self._told.get(part) != told:
                self._told[part] = told
                self._node.get_logger().error(f"waits for {told}")
        crowded = self.crowded()
        for part, told in crowded.items():
            if self._crowd.get(part) != told:
                self._node.get_logger().warning(told)
        self._crowd = crowded

    def _explain(self, part: str, why: str) -> str:
        one = self._inputs[part]
        topic = self._node.resolve_topic_name(one.topic)
        wanted = f"{topic} ({one.type_name}, any QoS)"
        infos = self._node.get_publishers_info_by_topic(one.topic)
        if not infos:
            others = self._elsewhere(one.type_name, topic)
            seen = f", but {one.type_name} on {', '.join(others)}" if others else ""
            domain = os.environ.get("ROS_DOMAIN_ID") or "0"
            target = others[0] if len(others) == 1 else "/YOUR/TOPIC"
            return (
                f"{wanted}: nobody publishes it in ROS_DOMAIN_ID {domain}{seen}; "
                f"publish it, or remap: --ros-args -r {one.topic}:={target}"
            )
        publishers = ", ".join(sorted({_name_of(info) for info in infos}))
        types = sorted({info.topic_type for info in infos})
        if one.type_name not in types:
            known = {foreign_repair.OBJECTS: [*OBJECT_READERS], foreign_repair.COMMAND: [*COMMAND_FORMS]}.get(part, [])
            fit = next((each for each in types if each in known), "")
            mend = f"-p {part}_type:={fit}" if fit else "publish that type, or remap another topic"
            return f"{wanted}: {publishers} publishes {', '.join(types)} there; {mend}"
        return f"{wanted}: {why or f'{publishers} publishes it, but nothing arrives in time'}"

    def _elsewhere(self, type_name: str, topic: str) -> list[str]:
        """Topics with messages of a type that others publish."""
        me = self._node.get_name(), self._node.get_namespace()
        return [
            name
            for name, types in self._node.get_topic_names_and_types()
            if type_name in types
            and name != topic
            and any(
                (info.node_name, info.node_namespace) != me for info in self._node.get_publishers_info_by_topic(name)
            )
        ]


def _name_of(publisher: Any) -> str:
    """The node that publishes; DDS tells of a publisher a moment before it tells whose it is."""
    if "UNKNOWN" in publisher.node_name:
        return "somebody"
    return f"{publisher.node_namespace.rstrip('/')}/{publisher.node_name}"


def _find(name: str, value: str, known: dict[str, Any]) -> Any:
    if value not in known:
        raise InputError(f"parameter {name}", f"{value!r} cannot be read here", f"choose {' or '.join(known)}")
    return known[value]
