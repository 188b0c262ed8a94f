"""viz_node between a pretended graph and a pretended display, in one process."""

import os
import time

import numpy as np
import pytest
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import Odometry, Path
from rclpy.experimental import EventsExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from roadmend_msgs import msg
from std_msgs.msg import Float64
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker, MarkerArray

from roadmend.core.command import Trajectory
from roadmend.core.outcome import Event, EventKind
from roadmend.core.repair import RepairStatus
from roadmend.core.route import Route, Stage
from roadmend.core.scene import EgoState, ObjectKind, ObjectList
from roadmend.nodes import qos, viz
from roadmend.recording import topics
from roadmend.recording.codec import encode
from roadmend.recording.messages import (
    MAP,
    OBJECTS,
    REPAIR,
    TRAJECTORY,
    ego_message_of,
    event_message_of,
    header_of,
    map_message_of,
    object_message_of,
    route_message_of,
    trajectory_message_of,
)
from roadmend.world.road_network import LaneMap

LIMIT_S = 10.0  # [s] for anything to arrive
OUTPUTS = {
    topics.MARKERS_OBJECTS: (MarkerArray, qos.STREAM),
    topics.MARKERS_EGO: (MarkerArray, qos.STREAM),
    topics.MARKERS_PLAN: (MarkerArray, qos.STREAM),
    topics.MARKERS_MAP: (MarkerArray, qos.LATCHED),
    topics.PLAN: (Path, qos.STREAM),
    topics.DISTANCE: (Float64, qos.STREAM),
    topics.TF: (TFMessage, qos.STREAM),
    topics.DIAGNOSTICS: (DiagnosticArray, qos.DIAGNOSTIC),
}


class Theatre:
    """Publishes what the graph would and keeps what comes back."""

    def __init__(self) -> None:
        self.node, self.viz = Node("pretended"), viz.VizNode()
        self.got = {topic: [] for topic in OUTPUTS}
        for topic, (kind, quality) in OUTPUTS.items():
            self.node.create_subscription(kind, topic, self.got[topic].append, quality)
        make = self.node.create_publisher
        self.to = {
            topics.EGO: make(Odometry, topics.EGO, qos.STREAM),
            topics.OBJECTS: make(msg.ObjectList, topics.OBJECTS, qos.STREAM),
            topics.POLICY_TRAJECTORY: make(msg.Trajectory, topics.POLICY_TRAJECTORY, qos.STREAM),
            topics.REPAIR_STATE: make(msg.RepairState, topics.REPAIR_STATE, qos.STREAM),
            topics.ROUTE: make(msg.Route, topics.ROUTE, qos.LATCHED),
            topics.MAP: make(msg.Map, topics.MAP, qos.LATCHED),
            topics.EVENTS: make(msg.ScenarioEvent, topics.EVENTS, qos.EVENT),
        }
        self.executor = EventsExecutor()
        for node in (self.node, self.viz):
            self.executor.add_node(node)
        self.until(lambda: all(publisher.get_subscription_count() for publisher in self.to.values()))
        names = [self.viz.resolve_topic_name(topic) for topic in OUTPUTS]
        self.until(lambda: all(self.viz.count_subscribers(name) for name in names))

    def send(self, topic: str, message) -> None:
        self.to[topic].publish(encode(message))

    def until(self, done) -> None:
        limit = time.monotonic() + LIMIT_S
        while not done():
            assert time.monotonic() < limit, "nothing came"
            self.executor.spin_once(timeout_sec=0.02)

    def settle(self, duration: float = 0.3) -> None:
        end = time.monotonic() + duration
        while time.monotonic() < end:
            self.executor.spin_once(timeout_sec=0.02)

    def tick(self, number: int, *, state: bool = True, objects: bool = True) -> None:
        header = header_of(0.05 * number)
        ego = EgoState.from_yaw(float(number), 0.0, 0.0, 5.0, 0.0, 4.0, 2.0)
        self.send(topics.EGO, ego_message_of(ego, header))
        if objects:
            cars = ObjectList.of(
                id=[7],
                kind=ObjectKind.CAR,
                x=number + 14.0,
                y=0.0,
                yaw=0.0,
                speed=1.0,
                acceleration=0.0,
                yaw_rate=0.0,
                length=4.0,
                width=2.0,
            )
            self.send(topics.OBJECTS, object_message_of(cars, np.empty(0, dtype=np.uint8), header))
        points = np.array([1.0, 2.0])
        plan = Trajectory(0.5, points, 0.0 * points, 0.0 * points, points)
        self.send(topics.POLICY_TRAJECTORY, trajectory_message_of(plan, header))
        if state:
            self.send(
                topics.REPAIR_STATE,
                REPAIR(
                    header=header,
                    state=int(RepairStatus.REPAIRED),
                    trigger_id=np.array([7], dtype=np.uint32),
                    trigger_weight=np.ones(1),
                ),
            )
        self.settle(0.01)

    def drawn(self, topic: str = topics.MARKERS_EGO) -> list[float]:
        stamps = [message.markers[0].header.stamp for message in self.got[topic]]
        return [stamp.sec + stamp.nanosec * 1e-9 for stamp in stamps]


@pytest.fixture
def stage(monkeypatch, tmp_path):
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path))
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    worker = int(os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw"))
    # Domains are few: a namespace keeps other graphs on this machine out where two tests draw the same one.
    rules = [f"__ns:=/test_{os.getpid()}", "/tf:=tf", "/diagnostics:=diagnostics"]
    args = ["viz", "--ros-args", "-p", "load:=1.0", *(word for rule in rules for word in ("-r", rule))]
    rclpy.init(domain_id=1 + (os.getpid() * 11 + worker) % 100, args=args)
    try:
        built = Theatre()
        yield built
        for node in (built.node, built.viz):
            built.executor.remove_node(node)
            node.destroy_node()
        built.executor.shutdown()
    finally:
        rclpy.try_shutdown()


def test_draws_at_its_rate_and_pairs_by_stamp(stage):
    for number in range(9):
        stage.tick(number)
    stage.until(lambda: len(stage.drawn()) >= 5)
    stage.settle()
    for topic in (topics.MARKERS_EGO, topics.MARKERS_OBJECTS, topics.MARKERS_PLAN):
        assert stage.drawn(topic) == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.4])
    transform = stage.got[topics.TF][2].transforms[0]
    assert (transform.header.frame_id, transform.child_frame_id) == ("map", "base_link")
    assert (transform.header.stamp.nanosec, transform.transform.translation.x) == (200_000_000, 4.0)
    assert stage.got[topics.DISTANCE][0].data == pytest.approx(14.0 - 2.0 - 2.4)  # half the car, half the default ego
    assert len(stage.got[topics.PLAN][0].poses) == 2
    assert [marker.id for marker in stage.got[topics.MARKERS_OBJECTS][0].markers if marker.ns == "triggers"] == [7]


def test_last_tick_is_drawn_when_the_final_event_comes(stage):
    for number in range(4):
        stage.tick(number)
    stage.tick(5, state=False)
    stage.send(topics.EVENTS, event_message_of(Event(0.25, EventKind.COLLISION, "bang")))
    stage.until(lambda: stage.drawn()[-1:] == [pytest.approx(0.25)])
    assert any(marker.ns == "objects" for marker in stage.got[topics.MARKERS_OBJECTS][-1].markers)


def test_without_repair_node_each_tick_is_drawn_when_the_next_begins(stage):
    for number in range(4):
        stage.tick(number, state=False)
    stage.until(lambda: len(stage.drawn()) >= 2)
    assert stage.drawn() == pytest.approx([0.0, 0.1])


def test_a_tick_without_objects_is_drawn_without_them(stage):
    stage.tick(0)
    stage.tick(2, objects=False)
    stage.tick(3)
    stage.until(lambda: len(stage.drawn(topics.MARKERS_OBJECTS)) >= 2)
    assert stage.drawn(topics.MARKERS_OBJECTS)[1] == pytest.approx(0.1)
    assert [marker.action for marker in stage.got[topics.MARKERS_OBJECTS][1].markers] == [Marker.DELETEALL]


def test_a_new_episode_is_drawn_from_its_first_tick(stage):
    for number in range(10, 13):
        stage.tick(number)
    stage.tick(0)
    stage.until(lambda: stage.drawn()[-1:] == [0.0])
    assert stage.drawn() == pytest.approx([0.5, 0.6, 0.0])


def test_map_is_drawn_once_and_again_when_it_changes(stage):
    x, limit = np.array([0.0, 50.0]), np.full(2, 13.9)
    route = Route("straight on", 4.0, 2.0, 40.0, 60.0, (Stage(x, np.zeros(2), limit),), (), ())
    lane = LaneMap(np.zeros(1, np.int64), np.zeros(1, np.uint8), np.full(1, 3.2), x, np.zeros(2))
    lanes = map_message_of(lane, header_of(0.0))
    stage.send(topics.ROUTE, route_message_of(route, header_of(0.0)))
    stage.send(topics.MAP, lanes)
    stage.settle(0.1)
    for number in range(4):
        stage.tick(number)
    stage.until(lambda: stage.got[topics.MARKERS_MAP])
    assert len(stage.got[topics.MARKERS_MAP]) == 1
    names = {marker.ns for marker in stage.got[topics.MARKERS_MAP][0].markers}
    assert {"road", "edges", "route", "goal"} <= names
    stage.send(topics.MAP, lanes)
    stage.until(lambda: len(stage.got[topics.MARKERS_MAP]) == 2)  # without a tick: the timer draws it


def test_faults_in_the_input_are_reported_and_survived(stage):
    stage.send(topics.MAP, MAP(lane_begin=np.zeros(1, dtype=np.uint32)))
    header = header_of(0.0)
    stage.send(topics.OBJECTS, OBJECTS(header=header, id=np.array([1, 2], dtype=np.uint32)))
    stage.send(topics.EGO, ego_message_of(EgoState.from_yaw(0.0, 0.0, 0.0, 5.0, 0.0, 4.0, 2.0), header))
    stage.send(topics.POLICY_TRAJECTORY, TRAJECTORY(header=header))
    stage.send(topics.REPAIR_STATE, REPAIR(header=header))
    stage.until(lambda: stage.drawn() == [0.0])
    stage.until(lambda: any(b"\x01" in report.status[0].level for report in stage.got[topics.DIAGNOSTICS]))
    warning = next(report for report in stage.got[topics.DIAGNOSTICS] if report.status[0].level == b"\x01")
    assert "differ in length" in warning.status[0].message


@pytest.mark.parametrize("size", [4, 24])
def test_bytes_that_are_no_message_are_reported_and_survived(stage, size):
    header = header_of(0.0)
    whole = {
        topics.EGO: ego_message_of(EgoState.from_yaw(0.0, 0.0, 0.0, 5.0, 0.0, 4.0, 2.0), header),
        topics.OBJECTS: OBJECTS(header=header),
        topics.EVENTS: event_message_of(Event(0.0, EventKind.GOAL, "")),
        topics.MAP: MAP(header=header),
    }
    for topic, message in whole.items():
        stage.to[topic].publish(encode(message)[:size])
    stage.settle()
    stage.until(lambda: any(b"\x01" in report.status[0].level for report in stage.got[topics.DIAGNOSTICS]))
    for number in range(3):
        stage.tick(number)
    stage.until(lambda: len(stage.drawn()) >= 2)
    assert stage.drawn() == pytest.approx([0.0, 0.1])


def test_a_plan_that_nobody_can_use_is_drawn_as_absent(stage):
    points = np.array([1.0, 2.0])
    plan = trajectory_message_of(Trajectory(0.5, points, points, np.empty(0), points), header_of(0.0))
    header = header_of(0.0)
    stage.send(topics.EGO, ego_message_of(EgoState.from_yaw(0.0, 0.0, 0.0, 5.0, 0.0, 4.0, 2.0), header))
    stage.send(topics.POLICY_TRAJECTORY, plan)
    stage.tick(2)
    stage.until(lambda: len(stage.got[topics.PLAN]) >= 2)
    assert [len(path.poses) for path in stage.got[topics.PLAN]] == [0, 2]
    assert stage.drawn(topics.MARKERS_PLAN) == pytest.approx([0.0, 0.1])


def test_a_tick_that_cannot_be_drawn_is_reported_and_survived(stage, monkeypatch):
    draw = viz.draw_tick

    def drawing(scene, *more):
        if scene.time == 7.0:
            raise ValueError("no such colour")
        return draw(scene, *more)

    monkeypatch.setattr(viz, "draw_tick", drawing)
    stage.tick(140)
    stage.until(lambda: any(b"\x01" in report.status[0].level for report in stage.got[topics.DIAGNOSTICS]))
    warning = next(report for report in stage.got[topics.DIAGNOSTICS] if report.status[0].level == b"\x01")
    assert warning.status[0].message.startswith("the tick at 7.00 s cannot be drawn: ")
    for number in range(3):
        stage.tick(number)
    stage.until(lambda: stage.drawn()[-2:] == pytest.approx([0.0, 0.1]))


def test_an_ego_that_is_not_finite_draws_nothing(stage):
    stage.tick(0)
    lost = EgoState.from_yaw(float("nan"), 0.0, 0.0, 5.0, 0.0, 4.0, 2.0)
    stage.send(topics.EGO, ego_message_of(lost, header_of(0.1)))
    stage.tick(3)
    stage.tick(4)
    stage.until(lambda: len(stage.drawn()) >= 2)
    assert stage.drawn() == pytest.approx([0.0, 0.2])


def test_parameters_change_at_run_time_and_refuse_nonsense(stage):
    def refused(name: str, value: float) -> bool:
        return not stage.viz.set_parameters([Parameter(name, value=value)])[0].successful

    assert refused("rate", 0.0)
    assert refused("rate", float("nan"))
    assert refused("load", 2.0)
    assert refused("text_radius", -1.0)
    assert not refused("rate", 20.0)
    for number in range(3):
        stage.tick(number)
    stage.until(lambda: len(stage.drawn()) == 3)
    assert stage.drawn() == pytest.approx([0.0, 0.05, 0.1])
