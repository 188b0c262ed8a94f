"""What a replay plays and when, without ROS: topics, offsets, latched messages, offers and the playhead."""

import itertools

import pytest

from roadmend.core.errors import InputError
from roadmend.recording.codec import encode
from roadmend.recording.conversion import convert
from roadmend.recording.definitions import Definition, computed_hash, find
from roadmend.recording.messages import HEADER
from roadmend.recording.qos import Qos
from roadmend.recording.reader import BagReader
from roadmend.recording.replay import (
    DEPTH_MAX,
    Playhead,
    ReplaySource,
    check_definition,
    offer_of,
    select_topics,
)
from roadmend.recording.writer import BagWriter

from .idl import HEADER_IDL

SECOND = 10**9
LATCHED = Qos(history="unknown", depth=0, durability="transient_local")


@pytest.fixture
def bag(tmp_path, make):
    """Ten ticks 0.1 s apart on /a and /b, three messages on the latched /late at the first three ticks."""
    with BagWriter(tmp_path / "bag") as writer:
        writer.add_topic("/a", "std_msgs/msg/String", [Qos()])
        writer.add_topic("/b", "std_msgs/msg/String", [Qos()])
        writer.add_topic("/late", "std_msgs/msg/String", [LATCHED])
        for tick in range(10):
            time_ns = 7 * SECOND + tick * SECOND // 10
            for topic in ("/a", "/b", *(["/late"] if tick < 3 else [])):
                writer.write(topic, time_ns, make.text(f"{topic} {tick}"))
    return BagReader(tmp_path / "bag")


def test_a_tick_holds_all_messages_of_one_time_in_their_order(bag, make):
    ticks = list(ReplaySource(bag, ["/a", "/b"]).ticks())
    assert [tick.time_ns for tick in ticks] == [7 * SECOND + tick * SECOND // 10 for tick in range(10)]
    assert [[record.topic for record in tick.records] for tick in ticks] == [["/a", "/b"]] * 10
    assert ticks[3].records[1].data == make.text("/b 3")


def test_a_tick_too_large_for_memory_is_played_in_parts(bag, monkeypatch):
    monkeypatch.setattr("roadmend.recording.replay._TICK_BYTES_MAX", 1)
    ticks = list(ReplaySource(bag, ["/a", "/b"]).ticks())
    assert [len(tick.records) for tick in ticks] == [1] * 20
    assert all(before.time_ns <= after.time_ns for before, after in itertools.pairwise(ticks))


def test_an_offset_begins_there_and_brings_what_was_latched(bag, make):
    source = ReplaySource(bag, ["/a", "/late"], 0.5)
    assert next(source.ticks()).time_ns == 7 * SECOND + SECOND // 2
    assert [record.data for record in source.latched()] == [make.text(f"/late {tick}") for tick in range(3)]
    assert ReplaySource(bag, ["/a", "/late"]).latched() == []
    assert ReplaySource(bag, ["/a"], 0.5).latched() == []
    assert len(list(ReplaySource(bag, ["/a"], 0.9).ticks())) == 1


@pytest.mark.parametrize("offset", [-0.1, 0.91, float("nan"), float("inf")])
def test_an_offset_outside_the_bag_is_refused(bag, offset):
    with pytest.raises(InputError, match=r"start: .* s is outside the bag; give a time from 0 to 0.9 s"):
        ReplaySource(bag, ["/a"], offset)


def test_an_empty_bag_is_refused(tmp_path):
    with BagWriter(tmp_path / "empty"):
        pass
    with pytest.raises(InputError, match="holds no messages"):
        ReplaySource(BagReader(tmp_path / "empty"), [])


def test_topics_are_chosen_by_name(corpus):
    reader = BagReader(corpus[0])
    assert select_topics(reader, [], []) == [*reader.topics]
    assert select_topics(reader, ["ego", "/objects"], []) == ["/ego", "/objects", "/clock"]
    assert select_topics(reader, ["/ego"], ["clock"]) == ["/ego"]
    assert "/ego" not in select_topics(reader, [], ["/ego"])
    for wanted, exclude in ((["/nothing"], []), ([], ["/nothing"])):
        with pytest.raises(InputError, match=r"topic /nothing: is not in .*; choose from /clock, /diagnostics"):
            select_topics(reader, wanted, exclude)
    with pytest.raises(InputError, match="no topic is left to play"):
        select_topics(reader, ["/ego"], ["/ego", "/clock"])


def test_a_type_that_is_missing_or_defined_otherwise_is_refused(tmp_path, make):
    other = "string data\nint32 more\n"
    absent = Definition("absent_msgs/msg/None", "int32 data\n", "")
    with BagWriter(tmp_path / "bag") as writer:
        writer.add_topic("/same", "std_msgs/msg/String")
        writer.add_topic(
            "/unhashed",
            "std_msgs/msg/Float64",
            (),
            Definition("std_msgs/msg/Float64", find("std_msgs/msg/Float64").text, ""),
        )
        writer.add_topic("/other", "std_msgs/msg/Bool", (), Definition("std_msgs/msg/Bool", other, ""))
        writer.add_topic("/absent", absent.type_name, (), absent)
        for topic in ("/same", "/unhashed", "/other", "/absent"):
            writer.write(topic, 0, make.text("x"))
    reader = BagReader(tmp_path / "bag")
    check_definition(reader, "/same")
    check_definition(reader, "/unhashed")
    assert computed_hash("std_msgs/msg/Bool", other) != find("std_msgs/msg/Bool").type_hash
    with pytest.raises(InputError, match="/other: was recorded with another definition of std_msgs/msg/Bool"):
        check_definition(reader, "/other")
    with pytest.raises(InputError, match="no such message type is installed"):
        check_definition(reader, "/absent")


def test_a_type_that_was_made_from_idl_is_read_converted_and_played(tmp_path):
    message = HEADER(frame_id="map")
    with BagWriter(tmp_path / "bag") as writer:
        definition = Definition("std_msgs/msg/Header", HEADER_IDL, "", "ros2idl")
        writer.add_topic("/header", definition.type_name, (), definition)
        writer.write("/header", 7, encode(message))
    reader = BagReader(tmp_path / "bag")
    assert [each.value.frame_id for each in reader.messages()] == ["map"]
    check_definition(reader, "/header")
    assert convert(tmp_path / "bag", tmp_path / "sql", "sqlite3").messages == 1
    assert convert(tmp_path / "sql", tmp_path / "again", "mcap").messages == 1
    assert BagReader(tmp_path / "again").definitions["std_msgs/msg/Header"].text == HEADER_IDL


def test_an_incomplete_definition_is_refused_in_one_line(tmp_path):
    with BagWriter(tmp_path / "bag") as writer:
        definition = Definition("my_msgs/msg/Outer", "Other one\n", "")
        writer.add_topic("/outer", definition.type_name, (), definition)
        writer.write("/outer", 7, encode(HEADER()))
    message = "definition of my_msgs/msg/Outer: lacks the type 'my_msgs/msg/Other'"
    with pytest.raises(InputError, match=message):
        check_definition(BagReader(tmp_path / "bag"), "/outer")
    with pytest.raises(InputError, match=message):
        convert(tmp_path / "bag", tmp_path / "sql", "sqlite3")
    assert not (tmp_path / "sql").exists()


def test_an_offer_serves_whoever_the_recorded_ones_served():
    known = Qos(depth=7, deadline_ns=SECOND)
    assert offer_of([known, known], 100) == known
    assert offer_of([], 100) == Qos()
    weak = Qos(depth=3, reliability="best_effort", lifespan_ns=SECOND)
    assert offer_of([weak, known], 100) == Qos(depth=7, deadline_ns=SECOND)
    assert offer_of([weak], 100).reliability == "best_effort"
    unknown = Qos(history="unknown", depth=0)
    assert offer_of([unknown], 5).depth == 5
    assert offer_of([unknown, LATCHED], 5) == Qos(history="unknown", depth=5, durability="transient_local")
    assert offer_of([LATCHED], 10**6).depth == DEPTH_MAX


def test_the_playhead_runs_stands_and_changes_its_pace():
    head = Playhead(10.0)
    head.seek(5 * SECOND, 100.0)
    assert head.time_ns(100.5) == 10 * SECOND
    head.pause(100.5)
    assert head.time_ns(200.0) == 10 * SECOND
    head.pause(200.0)
    head.resume(200.0)
    head.resume(200.1)
    assert head.time_ns(200.2) == pytest.approx(12 * SECOND)
    head.set_rate(1.0, 200.2)
    assert head.time_ns(201.2) == pytest.approx(13 * SECOND)
    waiting = Playhead(1.0, paused=True)
    waiting.seek(SECOND, 0.0)
    assert waiting.time_ns(50.0) == SECOND
