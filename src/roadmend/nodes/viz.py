"""Draws the running graph: markers, the plan as a path, and frames, for Foxglove and RViz."""

import math
import sys
import time
from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
from nav_msgs.msg import Odometry
from pydantic import Field
from rcl_interfaces.msg import SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.serialization import deserialize_message
from roadmend_msgs import msg
from std_msgs.msg import Header
from visualization_msgs.msg import MarkerArray

from roadmend.core.command import Trajectory
from roadmend.core.geometry import nearest_distance
from roadmend.core.outcome import EventKind
from roadmend.core.parameters import Parameters
from roadmend.core.route import Route
from roadmend.core.scene import EgoState, ObjectList, Scene
from roadmend.nodes import qos
from roadmend.nodes.convert import MAP_FRAME, ego_of, nanoseconds_of, objects_of, route_of, trajectory_of
from roadmend.nodes.diagnostics import DiagnosticsReporter, Health, Level
from roadmend.nodes.drawing import DRAWINGS, MARKERS_MAP, draw_tick
from roadmend.nodes.marker_map import map_markers
from roadmend.nodes.marker_ticks import NANOSECONDS, Cadence, TickMemory
from roadmend.nodes.parameters import declare_parameters
from roadmend.nodes.spinning import run_node

DEFAULT_SIZE = (4.8, 1.8)  # [m] of the ego until its route has told
PATIENCE_S = 0.5  # [s] of simulation time for which a topic counts as present after its last message

_TICK_TOPICS = {
    qos.EGO: Odometry,
    qos.OBJECTS: msg.ObjectList,
    qos.POLICY_TRAJECTORY: msg.Trajectory,
    qos.REPAIR_STATE: msg.RepairState,
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
        self._stamp = Header(frame_id=MAP_FRAME).stamp
        self._fault = ""
        self._create_outputs()
        for topic, kind in _TICK_TOPICS.items():
            self.create_subscription(kind, topic, partial(self._on_bytes, topic), qos.STREAM, raw=True)
        self.create_subscription(msg.Route, qos.ROUTE, self._on_route, qos.LATCHED)
        self.create_subscription(msg.Map, qos.MAP, self._on_map, qos.LATCHED, raw=True)
        self.create_subscription(msg.ScenarioEvent, qos.EVENTS, self._on_event, qos.EVENT)
        nearest_distance(EgoState.from_yaw(0.0, 0.0, 0.0, 0.0, 0.0, *DEFAULT_SIZE), ObjectList.empty())  # compile
        self._diagnostics = DiagnosticsReporter(self, self._health)

    def _create_outputs(self) -> None:
        self._outputs = {topic: self.create_publisher(kind, topic, qos.STREAM) for topic, kind in DRAWINGS.items()}
        self._to_map = self.create_publisher(MarkerArray, MARKERS_MAP, qos.LATCHED)

    def _on_parameters(self, changed: list[Parameter]) -> None:
        names = VizParameters.model_fields
        if any(parameter.name in names for parameter in changed):
            self._settings = VizParameters(**{name: self.get_parameter(name).value for name in names})
            self._cadence.set(self._settings.rate, self._settings.load)

    def _on_bytes(self, topic: str, data: bytes) -> None:
        before = self._memory.newest(qos.EGO)
        stamp = self._memory.put(topic, data)
        if topic == qos.EGO and before is not None:
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
        return self._memory.at(qos.EGO, stamp) is not None

    def _on_route(self, message: msg.Route) -> None:
        try:
            self._route = route_of(message)
        except (ValueError, IndexError) as error:
            self._fault = f"route: {error}"
            return
        self._map_is_due = True

    def _on_map(self, data: bytes) -> None:
        self._map = data
        self._map_is_due = True

    def _on_event(self, message: msg.ScenarioEvent) -> None:
        kind = EventKind(message.kind) if message.kind in set(EventKind) else EventKind.ABORTED
        if kind is EventKind.STARTED:
            self._memory.drop_after(nanoseconds_of(message.header.stamp))
            self._restart()
        elif kind.is_final:
            self._final_draws = len(_TICK_TOPICS)  # the event may overtake the messages of its tick
            newest = self._memory.newest(qos.EGO)
            if newest is not None:
                self._draw(newest, at_once=True)

    def _restart(self) -> None:
        self._final_draws = 0
        self._cadence.restart()

    def _draw(self, stamp: int, *, at_once: bool = False) -> None:
        raw_ego = self._memory.at(qos.EGO, stamp)
        if raw_ego is None or not (at_once or self._cadence.may_draw(time.monotonic())):
            return
        begin = time.thread_time()
        size = DEFAULT_SIZE if self._route is None else (self._route.ego_length, self._route.ego_width)
        odometry = deserialize_message(raw_ego, Odometry)
        ego = ego_of(odometry, *size)
        if all(math.isfinite(value) for value in (ego.x, ego.y, ego.yaw, ego.speed, *size)):
            self._stamp = odometry.header.stamp
            self._publish(ego, Header(stamp=self._stamp, frame_id=MAP_FRAME), stamp)
            self._drawn += 1
        else:
            self._fault = "ego: a number is not finite"
        self._last_draw_s = time.thread_time() - begin
        self._cadence.drawn(stamp, time.monotonic(), self._last_draw_s)
        if self._map_is_due:
            self._draw_map()  # after the tick: it takes long, and thousands of ticks may pass meanwhile

    def _publish(self, ego: EgoState, header: Header, stamp: int) -> None:
        objects, signals = self._objects_at(stamp)
        raw = self._decoded(qos.POLICY_TRAJECTORY, stamp)
        plan = Trajectory.empty() if raw is None else trajectory_of(raw)
        scene = Scene(stamp / NANOSECONDS, ego, objects, signals)
        state = self._decoded(qos.REPAIR_STATE, stamp)
        for topic, drawing in draw_tick(scene, plan, state, self._route, header, self._settings.text_radius):
            self._outputs[topic].publish(drawing)

    def _decoded(self, topic: str, stamp: int) -> Any:
        data = self._memory.at(topic, stamp)
        return None if data is None else deserialize_message(data, _TICK_TOPICS[topic])

    def _objects_at(self, stamp: int) -> tuple[ObjectList, np.ndarray]:
        message = self._decoded(qos.OBJECTS, stamp)
        if message is not None:
            try:
                return objects_of(message)
            except ValueError as error:
                self._fault = str(error)
        return ObjectList.empty(), np.empty(0, dtype=np.uint8)

    def _draw_map(self) -> None:
        """Publish lanes and route; latched, and complete in this one message."""
        self._map_is_due = False
        header = Header(stamp=self._stamp, frame_id=MAP_FRAME)
        lanes = None if self._map is None else deserialize_message(self._map, msg.Map)
        if lanes is not None:
            header.stamp = lanes.header.stamp
        try:
            self._to_map.publish(map_markers(lanes, self._route, header))
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
        if self._memory.newest(qos.EGO) is None:
            return Health(Level.OK, f"waiting for {self.resolve_topic_name(qos.EGO)}", values)
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
