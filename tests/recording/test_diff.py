"""Two bags held against each other."""

import json
import math

import numpy as np
import pytest
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from roadmend.cli.main import main
from roadmend.core.errors import InputError
from roadmend.recording.definitions import find
from roadmend.recording.deviation import deviations
from roadmend.recording.diff import bag_diff
from roadmend.recording.writer import BagWriter

TICK = 50_000_000
ODOMETRY, TEXT, BOOL = "nav_msgs/msg/Odometry", "std_msgs/msg/String", "std_msgs/msg/Bool"
FILL = b"base_link\x00" + bytes(2)  # the text ends two bytes before the next number may begin
STORE = get_typestore(Stores.ROS2_JAZZY)


def odometry(x, y=0.0):
    types = STORE.types
    none = types["geometry_msgs/msg/Vector3"](x=0.0, y=0.0, z=0.0)
    turn = types["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0)
    place = types["geometry_msgs/msg/Point"](x=x, y=y, z=0.0)
    pose = types["geometry_msgs/msg/Pose"](position=place, orientation=turn)
    header = types["std_msgs/msg/Header"](stamp=types["builtin_interfaces/msg/Time"](sec=0, nanosec=0), frame_id="map")
    return types[ODOMETRY](
        header=header,
        child_frame_id="base_link",
        pose=types["geometry_msgs/msg/PoseWithCovariance"](pose=pose, covariance=np.zeros(36)),
        twist=types["geometry_msgs/msg/TwistWithCovariance"](
            twist=types["geometry_msgs/msg/Twist"](linear=none, angular=none), covariance=np.zeros(36)
        ),
    )


def cdr(value):
    return bytes(STORE.serialize_cdr(value, value.__msgtype__))


@pytest.fixture
def bag(tmp_path):
    """Writes ten ticks of /ego and of a text; ``shift`` maps a tick to how far the ego is off."""

    def write(name, shift=lambda _tick: 0.0, texts=lambda tick: f"{tick}", ticks=10, padding=bytes(2), **metadata):
        with BagWriter(tmp_path / name) as writer:
            writer.add_topic("/ego", ODOMETRY)
            writer.add_topic("/note", TEXT)
            writer.add_topic("/diagnostics", TEXT)
            writer.add_topic("/configuration", TEXT)
            writer.add_metadata("roadmend", metadata)
            for topic in ("/diagnostics", "/configuration"):
                writer.write(topic, 0, cdr(STORE.types[TEXT](data=name)))
            for tick in range(ticks):
                writer.write("/ego", tick * TICK, cdr(odometry(tick + shift(tick))).replace(FILL, FILL[:-2] + padding))
                if texts(tick) is not None:
                    writer.write("/note", tick * TICK, cdr(STORE.types[TEXT](data=texts(tick))))
        return tmp_path / name

    return write


def test_equal_bags(bag):
    diff = bag_diff(bag("a", method="rss"), bag("b", method="rss"))
    assert diff.is_equal
    assert (diff.ticks, diff.differing_ticks, diff.first_difference) == (10, 0, None)
    assert set(diff.topics) == {"/ego", "/note"}
    assert diff.trajectories["/ego"].largest == 0.0
    assert diff.metadata == {}


def test_a_final_tick_that_is_sent_twice_is_one_of_the_distance(tmp_path):
    for name, shift in (("a", 0.0), ("b", 3.0)):
        with BagWriter(tmp_path / name) as writer:
            writer.add_topic("/ego", ODOMETRY)
            for tick, off in ((0, 0.0), (1, shift), (1, shift)):
                writer.write("/ego", tick * TICK, cdr(odometry(tick + off)))
    diff = bag_diff(tmp_path / "a", tmp_path / "b")
    distance = diff.trajectories["/ego"]
    assert (diff.ticks, distance.ticks, distance.mean, distance.last) == (2, 2, 1.5, 3.0)


def test_padding_is_no_difference(bag):
    assert bag_diff(bag("a"), bag("b", padding=b"\x12\x34")).is_equal


def test_the_first_tick_that_differs_and_how_far(bag):
    diff = bag_diff(bag("a"), bag("b", shift=lambda tick: 0.5 * max(0, tick - 6)))
    assert not diff.is_equal
    assert (diff.differing_ticks, diff.first_difference) == (3, pytest.approx(0.35))
    ego = diff.topics["/ego"]
    assert (ego.first_messages, ego.second_messages, ego.differing) == (10, 10, 3)
    assert ego.largest == {"pose.pose.position.x": 1.5}
    path = diff.trajectories["/ego"]
    assert (path.ticks, path.mean, path.largest, path.largest_at, path.last) == (
        10,
        pytest.approx(0.3),
        1.5,
        pytest.approx(0.45),
        1.5,
    )
    assert diff.topics["/note"].differing == 0


def test_messages_that_one_bag_lacks(bag):
    diff = bag_diff(bag("a"), bag("b", ticks=8, texts=lambda tick: None if tick == 3 else f"{tick}"))
    assert diff.first_difference == pytest.approx(0.15)
    note = diff.topics["/note"]
    assert (note.first_messages, note.second_messages, note.differing) == (10, 7, 3)
    assert (diff.ticks, diff.differing_ticks, diff.trajectories["/ego"].ticks) == (10, 3, 8)


def test_several_messages_of_one_topic_and_time_are_compared_in_order(tmp_path):
    for name, order in (("a", "xyz"), ("b", "xzy")):
        with BagWriter(tmp_path / name) as writer:
            writer.add_topic("/note", TEXT)
            for text in order:
                writer.write("/note", 5, cdr(STORE.types[TEXT](data=text)))
    diff = bag_diff(tmp_path / "a", tmp_path / "b")
    assert (diff.topics["/note"].differing, diff.differing_ticks) == (2, 1)
    assert diff.topics["/note"].largest == {"data": math.inf}


@pytest.mark.parametrize(("texts", "equal"), [("xxx", True), ("xx", True), ("xy", False), ("xxy", False)])
def test_a_tick_that_is_repeated_until_it_is_answered_counts_once(tmp_path, texts, equal):
    for name, order in (("a", "x"), ("b", texts)):
        with BagWriter(tmp_path / name) as writer:
            writer.add_topic("/note", TEXT)
            for text in order:
                writer.write("/note", 5, cdr(STORE.types[TEXT](data=text)))
    assert bag_diff(tmp_path / "a", tmp_path / "b").is_equal == equal


def test_a_topic_of_two_types(tmp_path):
    for name, kind in (("a", TEXT), ("b", BOOL)):
        with BagWriter(tmp_path / name) as writer:
            writer.add_topic("/note", kind)
            writer.write("/note", 5, bytes(8))
    diff = bag_diff(tmp_path / "a", tmp_path / "b")
    assert not diff.is_equal
    assert diff.types == {"/note": (TEXT, BOOL)}


def test_topics_can_be_chosen(bag):
    one, other = bag("a"), bag("b", shift=lambda _tick: 1.0)
    assert bag_diff(one, other, include="note").is_equal
    assert bag_diff(one, other, exclude="ego|diagnostics|configuration").is_equal
    assert not bag_diff(one, other, include="diagnostics", exclude="").is_equal
    with pytest.raises(InputError, match="hold no topic to compare"):
        bag_diff(one, other, include="absent")
    with pytest.raises(InputError, match="is not a regular expression"):
        bag_diff(one, other, include="[")


def test_the_command_and_its_exit_codes(bag, tmp_path, capsys):
    one, other = bag("a", method="rss"), bag("b", shift=lambda tick: tick == 9, method="none")
    assert main(["bag", "diff", str(one), str(one)]) == 0
    assert "equal: 10 ticks of 2 topics" in capsys.readouterr().out
    assert main(["bag", "diff", str(one), str(other)]) == 1
    printed = capsys.readouterr().out
    for words in (
        "different: 1 of 10 ticks, first at 0.450 s",
        "distance of /ego: at most 1 m (at 0.450 s), mean 0.1 m",
        "metadata method: rss and none",
        "pose.pose.position.x 1",
    ):
        assert words in printed
    assert main(["bag", "diff", "--json", str(one), str(other)]) == 1
    assert json.loads(capsys.readouterr().out)["first_difference"] == pytest.approx(0.45)
    assert main(["bag", "diff", str(one), str(tmp_path / "absent")]) == 2
    assert "there is no such bag" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("first", "second", "size"),
    [
        (math.nan, math.nan, None),
        (math.nan, 1.0, math.inf),
        (math.inf, math.inf, None),
        (math.inf, 1.0, math.inf),
        (1.0, 1.5, 0.5),
        (-0.0, 0.0, None),
    ],
)
def test_numbers_that_are_none(first, second, size):
    found = deviations(odometry(first), odometry(second))
    assert found == ({} if size is None else {"pose.pose.position.x": size})


def test_arrays_of_numbers_and_of_messages():
    store = get_typestore(Stores.EMPTY)
    name = "roadmend_msgs/msg/ObjectList"
    store.register(get_types_from_msg(find(name).text, name))
    empty = odometry(0.0)
    one, other = odometry(0.0), odometry(0.0)
    one.pose.covariance[:4] = [1.0, math.nan, math.inf, 2.0]
    other.pose.covariance[:4] = [1.0, math.nan, math.inf, 2.25]
    assert deviations(one, other) == {"pose.covariance[]": 0.25}
    assert deviations(one, empty) == {"pose.covariance[]": math.inf}
    path = STORE.types["nav_msgs/msg/Path"]
    stamped = STORE.types["geometry_msgs/msg/PoseStamped"]
    paths = [
        path(header=empty.header, poses=[stamped(header=empty.header, pose=odometry(x).pose.pose) for x in xs])
        for xs in ([0.0, 1.0], [0.0, 3.0], [0.0])
    ]
    assert deviations(paths[0], paths[1]) == {"poses[].pose.position.x": 2.0}
    assert deviations(paths[0], paths[2]) == {"poses": math.inf}
