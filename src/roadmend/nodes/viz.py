"""Draws the running graph: markers, the plan as a path, and frames, for Foxglove and RViz."""

import math
import sys
import time
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, TypeVar

import numpy as np
from nav_msgs.msg import Odometry, Path
from pydantic import Field
from rcl_interfaces.msg import SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter
from roadmend_msgs import msg
from std_msgs.msg import Float64
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import MarkerArray

from roadmend.core.command import Trajectory
from roadmend.core.geometry import nearest_distance
from roadmend.core.outcome import EventKind
from roadmend.core.parameters import Parameters
from roadmend.core.route import Route
from roadmend.core.scene import EgoState, ObjectList, Scene
from roadmend.nodes import qos
from roadmend.nodes.configuration import ConfigurationAnnouncer
from roadmend.nodes.diagnostics import DiagnosticsReporter, Health, Level
from roadmend.nodes.marker_ticks import Cadence, TickMemory
from roadmend.nodes.parameters import declare_parameters
from roadmend.nodes.spinning import run_node
from roadmend.recording import messages, topics
from roadmend.recording.codec import MessageType, encode
from roadmend.recording.drawing import draw_tick
from roadmend.recording.marker_map import map_markers
from roadmend.recording.messages import NANOSECONDS
from roadmend.repair.sanitise import usable_plan

Value = TypeVar("Value")

PATIENCE_S = 0.5  # [s] of simulation time for which a topic counts as present after its last message

_TICK_TOPICS = {
    topics.EGO: Odometry,
    topics.OBJECTS: msg.ObjectList,
    topics.POLICY_TRAJECTORY: msg.Trajectory,
    topics.REPAIR_STATE: msg.RepairState,
}
_DRAWINGS = {  # what is drawn at every tick
    topics.TF: TFMessage,
    topics.MARKERS_OBJECTS: MarkerArray,
    topics.MARKERS_EGO: MarkerArray,
    topics.MARKERS_PLAN: MarkerArray,
    topics.PLAN: Path,
    topics.DISTANCE: Float64,
}


class VizParameters(Parameters):
    """Parameters of the node; all can be changed while it runs."""

    rate: float = Field(10.0, ge=0.1, le=100.0, description="drawings a second of simulation time [Hz]")
    load: float = Field(0.5, ge=0.01, le=1.0, description="share of one processor that drawing may take at most")
    text_radius: float = Field(
        40.0, ge=0.0, le=1000.0, description="how near to the ego an object carries its id and speed [m]"
    )


class VizNode(Node):
    """Keeps the newest bytes of each topic and decodes them only where a tick is to be drawn.

    The first tick, the last one (a final event has come) and the first in each period of ``rate`` are drawn. What a
    tick lacks is drawn as absent, never as it was before.
    """

    def __init__(self) -> None:
        super().__init__("viz_node")
        self._settings = declare_parameters(self, VizParameters, is_fixed=False)
        self._configuration = ConfigurationAnnouncer(self, "viz")
        self.add_on_set_parameters_callback(_refuse_non_finite)
        self.add_post_set_parameters_callback(self._on_parameters)
        self._memory = TickMemory(tuple(_TICK_TOPICS))
        self._cadence = Cadence(self._settings.rate, self._settings.load)
        self._route: Route | None = None
        self._map: bytes | None = None
        self._map_is_due = False
        self._final_draws = 0  # how many more times a message of the last tick is drawn at once
        self._drawn = 0
        self._last_draw_s = 0.0
        self._stamp = 0  # [ns] of the last tick that was drawn
        self._fault = ""
        self._create_outputs()
        for topic, kind in _TICK_TOPICS.items():
            self.create_subscription(kind, topic, partial(self._on_bytes, topic), qos.STREAM, raw=True)
        self.create_subscription(msg.Route, topics.ROUTE, self._on_route, qos.LATCHED, raw=True)
        self.create_subscription(msg.Map, topics.MAP, self._on_map, qos.LATCHED, raw=True)
        self.create_subscription(msg.ScenarioEvent, topics.EVENTS, self._on_event, qos.EVENT, raw=True)
        nearest_distance(EgoState.from_yaw(0.0, 0.0, 0.0, 0.0, 0.0, *messages.EGO_SIZE), ObjectList.empty())  # compile
        usable_plan(Trajectory.empty())  # compile
        self._diagnostics = DiagnosticsReporter(self, self._health)
        self._configuration.announce()

    def _create_outputs(self) -> None:
        self._outputs = {topic: self.create_publisher(kind, topic, qos.STREAM) for topic, kind in _DRAWINGS.items()}
        self._to_map = self.create_publisher(MarkerArray, topics.MARKERS_MAP, qos.LATCHED)

    def _on_parameters(self, changed: list[Parameter]) -> None:
        names = VizParameters.model_fields
        if any(parameter.name in names for parameter in changed):
            self._settings = VizParameters(**{name: self.get_parameter(name).value for name in names})
            self._cadence.set(self._settings.rate, self._settings.load)

    def _on_bytes(self, topic: str, data: bytes) -> None:
        before = self._memory.newest(topics.EGO)
        try:
            stamp = self._memory.put(topic, data)
        except ValueError as error:
            self._fault = f"{topic}: {error}"
            return
        if topic == topics.EGO and before is not None:
            if stamp < before:
                self._memory.drop_after(stamp)
                self._restart()
            elif stamp > before and self._cadence.is_due(before):
                self._draw(before)  # the tick before never became complete: draw what there is of it
        if self._final_draws > 0:
            self._final_draws -= 1
            self._draw(stamp, at_once=True)
        elif self._cadence.is_due(stamp) and self._is_complete(stamp):
            self._draw(stamp)

    def _is_complete(self, stamp: int) -> bool:
        """Whether every topic that is alive has sent its message of this tick.

        A topic that has never sent may be about to: such a tick is drawn when the next one begins.
        """
        for topic in _TICK_TOPICS:
            newest = self._memory.newest(topic)
            if newest is None:
                return False
            if newest > stamp - PATIENCE_S * NANOSECONDS and self._memory.at(topic, stamp) is None:
                return False
        return self._memory.at(topics.EGO, stamp) is not None

    def _on_route(self, data: bytes) -> None:
        try:
            self._route = messages.route_of(messages.ROUTE.decode(data))
        except (ValueError, IndexError) as error:
            self._fault = f"route: {error}"
            return
        self._map_is_due = True

    def _on_map(self, data: bytes) -> None:
        self._map = data
        self._map_is_due = True

    def _on_event(self, data: bytes) -> None:
        try:
            event = messages.event_of(messages.EVENT.decode(data))
        except ValueError as error:
            self._fault = str(error)
            return
        if event is not None and event.kind is EventKind.STARTED:
            self._memory.drop_after(messages.stamp_of_bytes(data))
            self._restart()
        elif event is None or event.kind.is_final:
            self._final_draws = len(_TICK_TOPICS)  # the event may overtake the messages of its tick
            newest = self._memory.newest(topics.EGO)
            if newest is not None:
                self._draw(newest, at_once=True)

    def _restart(self) -> None:
        self._final_draws = 0
        self._cadence.restart()

    def _draw(self, stamp: int, *, at_once: bool = False) -> None:
        is_there = self._memory.at(topics.EGO, stamp) is not None
        if not is_there or not (at_once or self._cadence.may_draw(time.monotonic())):
            return
        begin = time.thread_time()
        size = messages.EGO_SIZE if self._route is None else (self._route.ego_length, self._route.ego_width)
        ego = self._read(topics.EGO, messages.EGO, lambda message: messages.ego_of(message, *size), stamp)
        if ego is not None and all(math.isfinite(value) for value in (ego.x, ego.y, ego.yaw, ego.speed, *size)):
            self._stamp = stamp
            self._publish(ego, stamp)
            self._drawn += 1
        elif ego is not None:
            self._fault = "ego: a number is not finite"
        self._last_draw_s = time.thread_time() - begin
        self._cadence.drawn(stamp, time.monotonic(), self._last_draw_s)
        if self._map_is_due:
            self._draw_map()  # after the tick: it takes long, and thousands of ticks may pass meanwhile

    def _publish(self, ego: EgoState, stamp: int) -> None:
        nobody = (ObjectList.empty(), np.empty(0, dtype=np.uint8))
        objects, signals = self._read(topics.OBJECTS, messages.OBJECTS, messages.objects_of, stamp) or nobody
        plan = self._read(topics.POLICY_TRAJECTORY, messages.TRAJECTORY, messages.trajectory_of, stamp)
        repair = self._read(topics.REPAIR_STATE, messages.REPAIR, messages.repair_of, stamp)
        scene = Scene(stamp / NANOSECONDS, ego, objects, signals)
        header = messages.header_at(stamp)
        radius = self._settings.text_radius
        try:
            for topic, drawing in draw_tick(scene, plan or Trajectory.empty(), repair, self._route, header, radius):
                self._outputs[topic].publish(encode(drawing))
        except Exception as error:  # noqa: BLE001 - a picture that fails must be seen, not end the node and so the run
            self._fault = f"the tick at {scene.time:.2f} s cannot be drawn: {error!r}"

    def _read(self, topic: str, kind: MessageType, value_of: Callable[[Any], Value], stamp: int) -> Value | None:
        """What a topic says of a tick; None where it says nothing, or nothing that can be read."""
        data = self._memory.at(topic, stamp)
        try:
            return None if data is None else value_of(kind.decode(data))
        except ValueError as error:
            self._fault = str(error)
            return None

    def _draw_map(self) -> None:
        """Publish lanes and route; latched, and complete in this one message."""
        self._map_is_due = False
        try:
            header = messages.header_at(self._stamp if self._map is None else messages.stamp_of_bytes(self._map))
            lanes = None if self._map is None else messages.lanes_of(messages.MAP.decode(self._map))
            self._to_map.publish(encode(map_markers(lanes, self._route, header)))
        except (ValueError, IndexError) as error:
            self._fault = str(error)

    def _health(self) -> Health:
        if self._map_is_due:
            self._draw_map()  # no tick has come since, so show at least where it will happen
        values = {
            "ticks drawn": self._drawn,
            "periods left out": self._cadence.left_out,
            "last drawing [ms]": f"{1e3 * self._last_draw_s:.2f}",
        }
        fault, self._fault = self._fault, ""
        if fault:
            return Health(Level.WARN, fault, values)
        if self._memory.newest(topics.EGO) is None:
            return Health(Level.OK, f"waiting for {self.resolve_topic_name(topics.EGO)}", values)
        return Health(Level.OK, "drawing", values)


def _refuse_non_finite(changed: list[Parameter]) -> SetParametersResult:
    for parameter in changed:
        if isinstance(parameter.value, float) and not math.isfinite(parameter.value):
            return SetParametersResult(successful=False, reason=f"{parameter.name} must be finite")
    return SetParametersResult(successful=True)


def main(args: Sequence[str] | None = None) -> int:
    """Run the node until it is told to stop."""
    return run_node(VizNode, args)


if __name__ == "__main__":
    sys.exit(main())
