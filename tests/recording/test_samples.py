"""The bags that the project ships, read by rosbags: that they show what their table says."""

from collections import Counter
from itertools import pairwise
from pathlib import Path

import pytest
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader

SAMPLES = Path(__file__).parents[2] / "bags" / "samples"
NAMES = ("collision", "repaired", "faults")
SIZE_MAX = 2_000_000  # [bytes] of all together
DELETE_ALL = 3  # visualization_msgs/Marker.DELETEALL


DRAWINGS = ("/markers/map", "/markers/objects", "/markers/ego", "/markers/plan")
TOPICS = ("/ego", "/ego/distance", "/events", "/repair/state")


def read(name, topics):
    """Messages by topic, in their order; of the many drawings, one in eight."""
    found = {topic: [] for topic in topics}
    with AnyReader([SAMPLES / name]) as reader:
        wanted = [connection for connection in reader.connections if connection.topic in topics]
        for place, (connection, _, data) in enumerate(reader.messages(wanted)):
            if connection.topic not in DRAWINGS or place % 8 == 0 or connection.topic == "/markers/map":
                found[connection.topic].append(reader.deserialize(data, connection.msgtype))
    return found


@pytest.fixture(scope="module")
def bags():
    return {name: read(name, TOPICS) for name in NAMES}


def account(name):
    """The metadata that the recorder wrote, and the scenario's file."""
    with (SAMPLES / name / f"{name}_0.mcap").open("rb") as file:
        reader = make_reader(file)
        records: dict[str, str] = {}
        for record in reader.iter_metadata():
            if record.name == "roadmend":
                records |= record.metadata
        return records, {one.name: one.data for one in reader.iter_attachments()}["demo-exit.yaml"]


def seconds(message):
    return message.header.stamp.sec + message.header.stamp.nanosec * 1e-9


def kinds(messages):
    return [event.kind for event in messages["/events"]]


def test_they_are_small_and_named():
    assert sorted(path.name for path in SAMPLES.iterdir() if path.is_dir()) == sorted(NAMES)
    assert sum(path.stat().st_size for path in SAMPLES.glob("*/*")) < SIZE_MAX
    text = (SAMPLES / "README.md").read_text("utf-8")
    for name in NAMES:
        assert f"| `{name}` |" in text
        assert f"--name {name}" in text


def test_all_are_of_one_scenario():
    accounts = {name: account(name) for name in NAMES}
    assert len({scenario for _, scenario in accounts.values()}) == 1
    assert {name: told["method"] for name, (told, _) in accounts.items()} == {
        "collision": "none",
        "repaired": "adreft",
        "faults": "adreft",
    }
    for told, _ in accounts.values():
        assert told["lost_messages"] == "0"
        assert told["outcome"] != "UNFINISHED"


def test_unrepaired_it_ends_in_a_collision(bags):
    bag = bags["collision"]
    assert kinds(bag)[-1] == bag["/events"][0].COLLISION
    assert not any(state.intervened for state in bag["/repair/state"])
    assert min(gap.data for gap in bag["/ego/distance"]) < 0.5


def test_repaired_it_reaches_its_goal(bags):
    bag = bags["repaired"]
    assert kinds(bag)[-1] == bag["/events"][0].GOAL
    repaired = [state for state in bag["/repair/state"] if state.intervened]
    assert len(repaired) >= 10
    assert all(state.final_action < state.policy_action for state in repaired)
    assert min(gap.data for gap in bag["/ego/distance"]) > 0.5


def test_faults_are_answered_by_braking_and_left_again(bags):
    bag = bags["faults"]
    event, state = bag["/events"][0], bag["/repair/state"][0]
    assert kinds(bag).index(event.WATCHDOG) < kinds(bag).index(event.RECOVERED)
    begin = next(seconds(one) for one in bag["/events"] if one.kind == event.WATCHDOG)
    end = next(seconds(one) for one in bag["/events"] if one.kind == event.RECOVERED)
    assert end - begin > 0.3
    answers = [seconds(one) for one in bag["/repair/state"] if begin < seconds(one) < end]
    assert all(answer > end - 0.1 for answer in answers)  # the node was dead, and its first answers end it
    speeds = [one.twist.twist.linear.x for one in bag["/ego"] if begin + 0.3 < seconds(one) < end]
    assert all(after <= before for before, after in pairwise(speeds))
    stale = [one for one in bag["/repair/state"] if one.state == state.STALE_COMMAND]
    assert len(stale) >= 5
    assert all(one.final_action < 0 for one in stale)
    assert bag["/repair/state"][-1].state != state.STALE_COMMAND


@pytest.mark.parametrize("name", NAMES)
def test_rosbags_finds_every_message(name):
    with AnyReader([SAMPLES / name]) as reader:
        found = Counter(connection.topic for connection, _, _ in reader.messages())
        assert found == {connection.topic: connection.msgcount for connection in reader.connections}


@pytest.mark.parametrize("name", NAMES)
def test_each_drawing_is_complete_wherever_one_seeks_to(name):
    for topic, drawings in read(name, DRAWINGS).items():
        assert drawings, topic
        for drawing in drawings:
            first, *others = [marker.action for marker in drawing.markers]
            assert first == DELETE_ALL, topic
            assert DELETE_ALL not in others, topic
