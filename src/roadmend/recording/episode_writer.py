"""Writes an episode that no graph drove into a bag, message by message as the graph's nodes would have sent it."""

from typing import Any

from roadmend.core.command import Command, Decision, Trajectory
from roadmend.core.outcome import Event
from roadmend.core.repair import Repair
from roadmend.core.route import Route
from roadmend.core.scene import Scene
from roadmend.recording import messages, topics
from roadmend.recording.codec import encode, type_of
from roadmend.recording.drawing import draw_tick
from roadmend.recording.marker_map import map_markers
from roadmend.recording.writer import BagWriter
from roadmend.world.road_network import LaneMap


class EpisodeWriter:
    """Writes core types as messages; their log time is the time of their tick, as the recorder has it.

    Args:
        writer: the bag.
        namespace: before every topic but the clock; empty or with a leading "/".
    """

    def __init__(self, writer: BagWriter, namespace: str = "") -> None:
        self._writer = writer
        self._namespace = namespace
        self._known: set[str] = set()

    def route(self, route: Route, lanes: LaneMap | None) -> None:
        """The ego's route, the map if there is one, and a drawing of both, at the beginning."""
        header = messages.header_of(0.0)
        self.put(topics.ROUTE, 0.0, messages.route_message_of(route, header))
        if lanes is not None:
            self.put(topics.MAP, 0.0, messages.map_message_of(lanes, header))
        self.put(topics.MARKERS_MAP, 0.0, map_markers(lanes, route, header))

    def scene(self, scene: Scene) -> None:
        """What there is to see at a tick, and its time."""
        header = messages.header_of(scene.time)
        self.put(topics.CLOCK, scene.time, messages.clock_message_of(scene.time))
        self.put(topics.EGO, scene.time, messages.ego_message_of(scene.ego, header))
        self.put(topics.OBJECTS, scene.time, messages.object_message_of(scene.objects, scene.signals, header))

    def decision(self, time: float, decision: Decision) -> None:
        """What the policy decided at ``time`` [s]."""
        header = messages.header_of(time)
        self.put(topics.POLICY_TRAJECTORY, time, messages.trajectory_message_of(decision.trajectory, header))
        self._command(topics.POLICY_COMMAND, time, decision.command)

    def repair(self, time: float, repair: Repair, method: str) -> None:
        """What a repair method answered at ``time`` [s]."""
        stamp = round(time * messages.NANOSECONDS)
        self.answer(stamp, stamp, repair, method)

    def answer(self, time_ns: int, stamp: int, repair: Repair, method: str) -> None:
        """What a repair method answered to the tick of ``stamp`` [ns], to the nanosecond; ``time_ns`` is its log time."""
        header = messages.header_at(stamp)
        self._put(topics.REPAIR_COMMAND, time_ns, messages.command_message_of(repair.command, header))
        self._put(topics.REPAIR_STATE, time_ns, messages.repair_message_of(repair, method, header))

    def event(self, event: Event) -> None:
        """Something that happened to the episode."""
        self.put(topics.EVENTS, event.time, messages.event_message_of(event))

    def drawing(
        self, scene: Scene, route: Route, decision: Decision | None = None, repair: Repair | None = None
    ) -> None:
        """What viz_node would draw of a tick."""
        plan = Trajectory.empty() if decision is None else decision.trajectory
        for topic, message in draw_tick(scene, plan, repair, route, messages.header_of(scene.time)):
            self.put(topic, scene.time, message)

    def put(self, topic: str, time: float, message: Any) -> None:
        """Write any message.

        Args:
            topic: its topic, relative unless it begins with "/".
            time: of its tick [s].
            message: as a ``MessageType`` makes it.
        """
        self._put(topic, round(time * messages.NANOSECONDS), message)

    def _put(self, topic: str, time_ns: int, message: Any) -> None:
        name = topic if topic.startswith("/") else f"{self._namespace}/{topic}"
        if name not in self._known:
            self._known.add(name)
            self._writer.add_topic(name, type_of(message), [topics.OFFERS.get(topic, topics.STREAM)])
        self._writer.write(name, time_ns, encode(message))

    def _command(self, topic: str, time: float, command: Command) -> None:
        self.put(topic, time, messages.command_message_of(command, messages.header_of(time)))
