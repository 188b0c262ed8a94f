"""What goes into a message comes out of it again, bit for bit."""

import dataclasses
import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from nav_msgs.msg import Odometry
from rclpy.serialization import deserialize_message, serialize_message
from roadmend_msgs import msg

from roadmend.core.command import Command, Trajectory
from roadmend.core.outcome import Blame, Event, EventKind
from roadmend.core.repair import Repair, RepairStatus, RepairTrigger
from roadmend.core.route import RightOfWay, Route, Stage, Window, Zone
from roadmend.core.scene import COLUMNS, EgoState, ObjectKind, ObjectList
from roadmend.recording import messages
from roadmend.recording.codec import MessageType, encode, type_of
from roadmend.world.road_network import LaneKind, LaneMap, RoadNetwork, lanes_of

NUMBERS = np.random.default_rng(4)


def sent(message):
    """A message as it arrives: through bytes that ROS's own library has read and written."""
    kind = getattr(msg, type_of(message).removeprefix("roadmend_msgs/msg/"), Odometry)
    return MessageType(type_of(message)).decode(serialize_message(deserialize_message(encode(message), kind)))


def header():
    return messages.header_of(1.25)


def objects_of_random(count):
    columns = dict(zip(COLUMNS[2:], NUMBERS.normal(size=(len(COLUMNS) - 2, count)), strict=True))
    return ObjectList.of(id=np.arange(1, count + 1), kind=np.arange(count) % 7, **columns)


def route():
    def stage(points):
        x = np.cumsum(NUMBERS.uniform(1.0, 2.0, points))
        return Stage(x, NUMBERS.normal(size=points), NUMBERS.uniform(5.0, 30.0, points))

    zones = tuple(
        Zone(number % 3, 10.0 + number, 20.0 + number, rule, number - 1) for number, rule in enumerate(RightOfWay)
    )
    stages, windows = (stage(4), stage(2), stage(7)), (Window(1.0, 2.0), Window(0.5, 1.5))
    return Route("some-name", 4.7, 1.85, 12.5, 60.0, stages, windows, zones)


@pytest.mark.parametrize("time", [0.0, 0.05, 1.0, 3.0 * 0.05, 86_400.0, 12345 * 50_000_000 * 1e-9])
def test_a_stamp_gives_back_the_tick(time):
    assert messages.stamp_of(messages.header_of(time)) == round(time * 1e9)
    assert round(time * 1e9) % 50_000_000 == 0


def test_a_header_names_frame_and_time():
    made = messages.header_of(2.5)
    assert (made.frame_id, made.stamp.sec, made.stamp.nanosec) == ("map", 2, 500_000_000)


@pytest.mark.parametrize("yaw", [0.0, 1.0, -3.0, math.pi])
def test_the_ego_is_the_same_after_the_journey(yaw):
    ego = EgoState.from_yaw(1.1, -2.2, yaw, 3.3, 0.4, 4.7, 1.85)
    assert messages.ego_of(sent(messages.ego_message_of(ego, header())), 4.7, 1.85) == ego


@pytest.mark.parametrize("count", [0, 1, 20, 300])
def test_objects_are_the_same_after_the_journey(count):
    objects, signals = objects_of_random(count), np.array([2, 0, 3], dtype=np.uint8)
    back, back_signals = messages.objects_of(sent(messages.object_message_of(objects, signals, header())))
    for name in COLUMNS:
        mine, other = getattr(objects, name), getattr(back, name)
        assert (mine.dtype, mine.tobytes()) == (other.dtype, other.tobytes()), name
    assert back_signals.tolist() == [2, 0, 3]


@pytest.mark.parametrize("column", COLUMNS)
@pytest.mark.parametrize("change", [-1, 1])
def test_objects_with_an_array_of_another_length_raise(column, change):
    message = messages.object_message_of(objects_of_random(3), np.empty(0, dtype=np.uint8), header())
    values = getattr(message, column)
    setattr(message, column, values[:-1] if change < 0 else np.append(values, values[:1]))
    with pytest.raises(ValueError, match="differ in length"):
        messages.objects_of(sent(message))


@pytest.mark.parametrize("command", [Command(0.3, 0.0), Command(0.0, 1.0, change_lane=True), Command(math.inf, -7.0)])
def test_a_command_is_the_same_after_the_journey(command):
    assert messages.command_of(sent(messages.command_message_of(command, header()))) == command


def test_not_a_number_stays_one_for_the_guard_to_see():
    assert messages.command_of(sent(messages.command_message_of(Command(math.nan, 0.0), header()))).fault


@pytest.mark.parametrize("points", [0, 1, 40])
def test_a_trajectory_is_the_same_after_the_journey(points):
    plan = Trajectory(0.1, *NUMBERS.normal(size=(4, points)), "yield")
    back = messages.trajectory_of(sent(messages.trajectory_message_of(plan, header())))
    assert (back.interval, back.behaviour, len(back)) == (0.1, "yield", points)
    for name in ("x", "y", "yaw", "speed"):
        assert getattr(back, name).tobytes() == getattr(plan, name).tobytes()


def test_a_route_is_the_same_after_the_journey():
    mine = route()
    back = messages.route_of(sent(messages.route_message_of(mine, header())))
    for name in ("scenario", "ego_length", "ego_width", "goal", "time_limit", "windows", "zones", "length"):
        assert getattr(back, name) == getattr(mine, name), name
    assert len(back.stages) == 3
    for one, other in zip(mine.stages, back.stages, strict=True):
        for name in ("x", "y", "speed_limit", "s"):
            assert getattr(one, name).tobytes() == getattr(other, name).tobytes(), name


@pytest.mark.parametrize(
    "column",
    [
        "x",
        "y",
        "speed_limit",
        "change_begin",
        "change_end",
        "zone_stage",
        "zone_begin",
        "zone_end",
        "zone_rule",
        "zone_signal",
    ],
)
def test_a_route_with_an_array_cut_short_raises(column):
    message = messages.route_message_of(route(), header())
    setattr(message, column, getattr(message, column)[:-1])
    with pytest.raises(ValueError):
        messages.route_of(sent(message))


@pytest.mark.parametrize("begins", [[], [1, 4, 6], [0, 4, 5], [0, 6, 4], [0, 4, 13], [0, 4, 99]])
def test_a_route_whose_stages_are_no_lines_raises(begins):
    message = messages.route_message_of(route(), header())
    message.stage_begin = np.array(begins, dtype=np.uint32)
    with pytest.raises(ValueError, match="two points"):
        messages.route_of(sent(message))


def test_a_route_with_a_zone_on_no_stage_raises():
    message = messages.route_message_of(route(), header())
    message.zone_stage = np.array([0, 1, 2, 3, 0], dtype=np.uint32)
    with pytest.raises(ValueError, match="a zone lies on stage 3 of 3, counted from 0"):
        messages.route_of(sent(message))


def test_a_route_with_more_windows_than_a_last_stage_can_follow_raises():
    message = messages.route_message_of(route(), header())
    message.change_begin = message.change_end = np.ones(3)
    with pytest.raises(ValueError, match="3 windows between 3 stages"):
        messages.route_of(sent(message))


def test_a_route_with_an_unknown_rule_raises():
    message = messages.route_message_of(route(), header())
    message.zone_rule = np.full(5, 9, dtype=np.uint8)
    with pytest.raises(ValueError, match="9"):
        messages.route_of(sent(message))


@pytest.mark.parametrize(
    ("column", "place", "value", "told"),
    [
        ("x", 0, math.nan, "a point of stage 0 is not finite"),
        ("y", 5, math.inf, "a point of stage 1 is not finite"),
        ("x", 12, 1e200, "a point of stage 2 is not finite"),
        ("speed_limit", 3, math.nan, "a speed limit of stage 0 is no number from 0 on"),
        ("speed_limit", 3, -1.0, "a speed limit of stage 0 is no number from 0 on"),
        ("change_end", 1, math.nan, "a window or a zone is not finite"),
        ("zone_begin", 2, -math.inf, "a window or a zone is not finite"),
    ],
)
def test_a_route_along_which_nobody_can_measure_raises(column, place, value, told):
    message = messages.route_message_of(route(), header())
    getattr(message, column)[place] = value
    with pytest.raises(ValueError, match=f"^route: {told}$"):
        messages.route_of(sent(message))


@pytest.mark.parametrize("place", [0, 2, 10])
def test_a_route_with_a_doubled_point_raises(place):
    message = messages.route_message_of(route(), header())
    for column in (message.x, message.y):
        column[place + 1] = column[place]
    with pytest.raises(ValueError, match=r"two points of stage [02] that follow each other are one"):
        messages.route_of(sent(message))


def test_a_route_without_a_goal_raises():
    message = messages.route_message_of(route(), header())
    message.goal = math.nan
    with pytest.raises(ValueError, match="its goal is no number"):
        messages.route_of(sent(message))


@pytest.mark.parametrize("status", RepairStatus)
def test_a_repair_arrives_complete(status):
    triggers = (RepairTrigger(7, 0.9), RepairTrigger(4_000_000_000, 0.1))
    repair = Repair(Command(0.0, 0.6), status, 0.8, 0.5, 0.3, -0.6, True, 3, triggers, "object 7 ahead", 0.1 + 0.2)
    back = sent(messages.repair_message_of(repair, "rss", header()))
    assert (back.state, back.method, back.reason) == (int(status), "rss", "object 7 ahead")
    assert (back.score, back.threshold, back.worth) == (0.8, 0.5, 0.1 + 0.2)
    assert (back.policy_action, back.repair_action, back.final_action) == (0.3, -0.6, -0.6)
    assert (back.intervened, back.dropped_objects) == (True, 3)
    assert (list(back.trigger_id), list(back.trigger_weight)) == ([7, 4_000_000_000], [0.9, 0.1])
    assert messages.repair_of(back) == repair


@pytest.mark.parametrize("worth", [None, 0.0, -0.25])
def test_no_worth_is_not_a_worth_of_nothing(worth):
    repair = Repair(Command(0.0, 0.6), RepairStatus.REPAIRED, 0.8, 0.5, 0.3, -0.6, True, worth=worth)
    back = sent(messages.repair_message_of(repair, "rss", header()))
    assert math.isnan(back.worth) == (worth is None)
    assert messages.repair_of(back).worth == worth


def test_repair_states_of_earlier_versions_tell_no_worth():
    message = messages.repair_message_of(
        Repair(Command(0.0, 0.6), RepairStatus.REPAIRED, 0.8, 0.5, 0.3, -0.6, True), "rss", header()
    )
    told = {name: getattr(message, name) for name in message.__dataclass_fields__ if name != "worth"}
    earlier = dataclasses.make_dataclass("Earlier", told)(**told)
    assert messages.repair_of(earlier).worth is None
    renewed = messages.renewed_repair_message_of(earlier)
    assert math.isnan(renewed.worth)
    assert {name: getattr(renewed, name) for name in told} == told


def test_an_action_that_is_not_finite_becomes_no_number():
    repair = Repair(Command(0.0, 0.5), RepairStatus.INVALID_COMMAND, math.nan, math.nan, math.inf, -math.inf, True)
    back = sent(messages.repair_message_of(repair, "none", header()))
    assert math.isnan(back.policy_action)
    assert math.isnan(back.repair_action)
    assert back.final_action == -0.5


@pytest.mark.parametrize("status", RepairStatus)
def test_states_mirror_the_message(status):
    assert getattr(msg.RepairState, status.name) == status


@pytest.mark.parametrize("kind", EventKind)
def test_an_event_is_the_same_after_the_journey(kind):
    kinds = ObjectKind.CAR, ObjectKind.PEDESTRIAN
    event = Event(2.5, kind, "bang", (3, 4), ("v1", "v2"), kinds, Blame.SIDE, 7.25)
    back = sent(messages.event_message_of(event))
    assert back.kind == getattr(msg.ScenarioEvent, kind.name) == kind
    assert messages.event_of(back) == event


def test_an_event_of_a_kind_that_is_not_known_is_none():
    assert messages.event_of(messages.EVENT(kind=200)) is None


def test_an_event_without_a_collision_blames_nobody():
    event = Event(2.5, EventKind.GOAL, "there")
    back = sent(messages.event_message_of(event))
    assert (list(back.object_kind), back.blame) == ([], msg.ScenarioEvent.BLAME_UNKNOWN)
    assert math.isnan(back.impact_speed)
    assert messages.event_of(back) == event


def test_bags_of_earlier_versions_do_not_say_who_is_to_blame():
    known = {"kind": 2, "object_id": np.array([7]), "object_name": ["a"], "text": "hit a"}
    value = SimpleNamespace(header=messages.header_of(1.0), **known)
    assert messages.event_of(value) == Event(1.0, EventKind.COLLISION, "hit a", (7,), ("a",))


@pytest.mark.parametrize("blame", Blame)
def test_blames_mirror_the_message(blame):
    assert getattr(msg.ScenarioEvent, f"BLAME_{blame.name}") == blame


def test_a_map_arrives_complete():
    x, y = NUMBERS.normal(size=(2, 10))
    kinds = np.array([*LaneKind], dtype=np.uint8)
    lanes = LaneMap(np.array([0, 2, 7]), kinds, 3.0 + kinds, x, y)
    back = sent(messages.map_message_of(lanes, header()))
    assert (again := messages.lanes_of(back)).x.tobytes() == x.tobytes()
    assert (again.begin.dtype, again.kind.dtype, again.width.tolist()) == (np.int64, np.uint8, [3.0, 4.0, 5.0])
    assert list(back.lane_begin) == [0, 2, 7]
    assert list(back.lane_kind) == [msg.Map.KIND_ROAD, msg.Map.KIND_JUNCTION, msg.Map.KIND_WALK]
    assert list(back.lane_width) == [3.0, 4.0, 5.0]
    assert (back.x.tobytes(), back.y.tobytes()) == (x.tobytes(), y.tobytes())


def test_a_map_without_lanes_is_empty():
    back = sent(messages.map_message_of(lanes_of(RoadNetwork(Path("empty.net.xml"), {}, {}, {})), header()))
    assert len(back.lane_begin) == len(back.x) == 0


number = st.floats(-1e4, 1e4)


@settings(max_examples=60, deadline=None)
@given(number, number, st.floats(-math.pi, math.pi), st.floats(0, 60), st.floats(-2, 2), st.integers(0, 10**12))
def test_the_ego_and_its_stamp_are_what_rclpy_reads_and_writes(x, y, yaw, speed, yaw_rate, stamp):
    ego = EgoState.from_yaw(x, y, yaw, speed, yaw_rate, 4.7, 1.85)
    data = encode(messages.ego_message_of(ego, messages.header_at(stamp)))
    read = deserialize_message(data, Odometry)
    assert messages.ego_of(read, 4.7, 1.85) == messages.ego_of(messages.EGO.decode(data), 4.7, 1.85) == ego
    assert messages.stamp_of_bytes(serialize_message(read)) == messages.stamp_of(read.header) == stamp


def test_a_stamp_is_read_without_decoding():
    assert messages.stamp_of_bytes(b"\x00\x00\x00\x00\x00\x00\x00\x01\x00\x00\x00\x02") == 1_000_000_002
    with pytest.raises(ValueError, match="too few"):
        messages.stamp_of_bytes(b"\x00\x01")


@pytest.mark.parametrize(
    "data", [b"", b"\x00\x01\x00\x00", b"\x00\x00\x00\x00" + bytes(700), b"\x00\x01\x00\x00" + b"\xff" * 40]
)
def test_other_bytes_are_refused(data):
    with pytest.raises(ValueError, match="the bytes are no nav_msgs/msg/Odometry"):
        messages.EGO.decode(data)


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"lane_kind": np.ones(1, np.uint8)}, "differ in length"),
        ({"lane_width": np.ones(1, np.float32)}, "differ in length"),
        ({"y": np.zeros(3)}, "differ in length"),
        ({"lane_begin": np.array([0, 9], np.uint32)}, "do not follow one another"),
        ({"lane_begin": np.array([3, 2], np.uint32)}, "do not follow one another"),
    ],
)
def test_a_map_whose_arrays_do_not_fit_is_refused(changed, words):
    lanes = LaneMap(np.array([0, 2]), np.ones(2, np.uint8), np.full(2, 3.0), np.zeros(4), np.zeros(4))
    message = dataclasses.replace(messages.map_message_of(lanes, header()), **changed)
    with pytest.raises(ValueError, match=words):
        messages.lanes_of(message)
