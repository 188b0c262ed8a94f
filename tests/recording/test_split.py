"""Bags of several files: split by size and by duration, each file able to stand by itself."""

import itertools

import pytest
import yaml
from mcap.reader import make_reader
from rosbags.rosbag2 import Reader

from roadmend.recording.errors import RecordingError
from roadmend.recording.qos import Qos
from roadmend.recording.reader import BagReader
from roadmend.recording.writer import BagOptions, BagWriter, Compression

SECOND = 10**9
TEXT = "std_msgs/msg/String"
LATCHED = Qos(depth=2, durability="transient_local")


@pytest.fixture
def split(tmp_path, make):
    """Three files of a second each: a stream, and a latched topic whose four messages all come at the start."""
    with BagWriter(tmp_path / "bag", BagOptions(max_bagfile_duration=1.0)) as writer:
        writer.add_topic("/stream", TEXT, [Qos()])
        writer.add_topic("/latched", TEXT, [LATCHED])
        writer.add_topic("/silent", TEXT, [Qos()])
        writer.add_metadata("roadmend", {"seed": "7"})
        writer.add_attachment("scenario.yaml", "application/yaml", b"name: merge\n")
        for number in range(4):
            writer.write("/latched", number, make.text(f"latched {number}"))
        for number in range(30):
            writer.write("/stream", number * SECOND // 10, make.text(f"{number}"))
        writer.add_metadata("roadmend", {"outcome": "GOAL"})
    assert writer.count == 34
    return tmp_path / "bag"


def texts(reader, topic):
    return [message.value.data for message in reader.messages([topic])]


def test_a_file_for_each_duration(split):
    assert sorted(path.name for path in split.iterdir()) == ["bag_0.mcap", "bag_1.mcap", "bag_2.mcap", "metadata.yaml"]
    information = yaml.safe_load((split / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert information["version"] == 9
    assert information["relative_file_paths"] == ["bag_0.mcap", "bag_1.mcap", "bag_2.mcap"]
    assert [
        (file["path"], file["starting_time"]["nanoseconds_since_epoch"], file["duration"]["nanoseconds"])
        for file in information["files"]
    ] == [("bag_0.mcap", 0, 900_000_000), ("bag_1.mcap", SECOND, 900_000_000), ("bag_2.mcap", 2 * SECOND, 900_000_000)]
    # The two that a late joiner would get stand again at the start of each further file.
    assert [file["message_count"] for file in information["files"]] == [14, 12, 12]
    assert information["message_count"] == 38
    counts = {one["topic_metadata"]["name"]: one["message_count"] for one in information["topics_with_message_count"]}
    assert counts == {"/stream": 30, "/latched": 8, "/silent": 0}
    assert information["duration"]["nanoseconds"] == 2_900_000_000


def test_our_reader_takes_each_message_once(split):
    reader = BagReader(split)
    assert texts(reader, "/stream") == [str(number) for number in range(30)]
    assert texts(reader, "/latched") == [f"latched {number}" for number in range(4)]
    assert (reader.count, reader.topics["/latched"].count) == (34, 4)
    assert reader.metadata["roadmend"] == {"seed": "7", "outcome": "GOAL"}
    assert reader.attachments["scenario.yaml"].data == b"name: merge\n"


@pytest.mark.parametrize("number", [0, 1, 2])
def test_each_file_stands_by_itself(split, number):
    with (split / f"bag_{number}.mcap").open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        summary = reader.get_summary()
        channels = {channel.topic: channel for channel in summary.channels.values()}
        assert set(channels) == {"/stream", "/latched"}
        offers = yaml.safe_load(channels["/latched"].metadata["offered_qos_profiles"])
        assert [offer["durability"] for offer in offers] == ["transient_local"]
        assert all(summary.schemas[channel.schema_id].name == TEXT for channel in channels.values())
        assert {one.name for one in reader.iter_metadata()} >= {"roadmend", "rosbag2"}
        assert [one.name for one in reader.iter_attachments()] == ["scenario.yaml"]
    alone = BagReader(split / f"bag_{number}.mcap")
    assert texts(alone, "/latched")[-2:] == ["latched 2", "latched 3"]
    assert len(texts(alone, "/stream")) == 10


def test_rosbags_reads_every_file(split):
    with Reader(split) as reader:
        assert reader.message_count == 38
        assert sum(1 for _ in reader.messages()) == 38
        assert reader.duration == 2_900_000_001


@pytest.mark.parametrize("compression", list(Compression))
def test_files_of_a_size(tmp_path, make, compression):
    options = BagOptions(compression, chunk_size=1000, max_bagfile_size=20_000)
    payloads = [make.random.bytes(500) for _ in range(200)]
    with BagWriter(tmp_path / "bag", options) as writer:
        writer.add_topic("/text", TEXT)
        for number, payload in enumerate(payloads):
            writer.write("/text", number, payload)
    files = sorted((tmp_path / "bag").glob("*.mcap"))
    assert len(files) >= 4
    assert all(file.stat().st_size < 25_000 for file in files)
    assert [record.data for record in BagReader(tmp_path / "bag").records()] == payloads


@pytest.mark.parametrize("where", ["attachment", "latched"])
def test_what_each_file_repeats_does_not_fill_it(tmp_path, make, where):
    options = BagOptions(chunk_size=1000, flush_interval=0.0, max_bagfile_size=100_000)
    with BagWriter(tmp_path / "bag", options) as writer:
        writer.add_topic("/text", TEXT)
        writer.add_topic("/map", TEXT, [LATCHED])
        if where == "attachment":
            writer.add_attachment("map", "application/octet-stream", make.random.bytes(150_000))
        else:
            writer.write("/map", 0, make.random.bytes(150_000))
        for number in range(50):
            writer.write("/text", number, make.text(f"{number}"))
    assert len(list((tmp_path / "bag").glob("*.mcap"))) <= 2
    assert len(texts(BagReader(tmp_path / "bag"), "/text")) == 50


def test_a_file_has_a_message_of_its_own_before_the_next_begins(tmp_path, make):
    with BagWriter(tmp_path / "bag", BagOptions(max_bagfile_duration=1.0)) as writer:
        writer.add_topic("/map", TEXT, [LATCHED])
        writer.write("/map", 0, make.text("first"))
        writer.split()
        writer.write("/map", 5 * SECOND, make.text("second"))
    assert [file.count for file in BagReader(tmp_path / "bag").files] == [1, 2]


def test_a_late_message_lies_in_the_next_file_and_is_read_in_order(tmp_path, make):
    with BagWriter(tmp_path / "bag", BagOptions(max_bagfile_duration=1.0)) as writer:
        writer.add_topic("/text", TEXT)
        for time_ns in (0, 5, SECOND, 3, SECOND + 1):
            writer.write("/text", time_ns, make.text(f"{time_ns}"))
    reader = BagReader(tmp_path / "bag")
    assert len(reader.files) == 2
    assert [record.time_ns for record in reader.records()] == [0, 3, 5, SECOND, SECOND + 1]


def test_a_late_latched_message_is_not_taken_for_one_that_is_repeated(tmp_path, make):
    with BagWriter(tmp_path / "bag", BagOptions(max_bagfile_duration=1.0)) as writer:
        writer.add_topic("/stream", TEXT)
        writer.add_topic("/events", TEXT, [LATCHED])
        writer.write("/events", 1, make.text("first"))
        for time_ns in (0, SECOND):
            writer.write("/stream", time_ns, make.text("tick"))
        writer.write("/events", SECOND - 1, make.text("collision"))
    reader = BagReader(tmp_path / "bag")
    assert len(reader.files) == 2
    assert texts(reader, "/events") == ["first", "collision"]


@pytest.mark.parametrize(
    ("offers", "held"),
    [
        ([LATCHED], ["2", "3"]),
        ([LATCHED, LATCHED], ["0", "1", "2", "3"]),
        ([Qos(depth=1, durability="transient_local"), Qos()], []),
        ([Qos(history="unknown", depth=0, durability="transient_local")], ["0", "1", "2", "3"]),
        ([Qos(history="keep_all", depth=0, durability="transient_local")], ["0", "1", "2", "3"]),
    ],
)
def test_what_a_late_joiner_would_get_is_repeated(tmp_path, make, offers, held):
    with BagWriter(tmp_path / "bag") as writer:
        writer.add_topic("/text", TEXT, offers)
        for number in range(4):
            writer.write("/text", number, make.text(f"{number}"))
        writer.split()
    assert texts(BagReader(tmp_path / "bag" / "bag_1.mcap"), "/text") == held


def test_a_next_file_that_cannot_be_made_is_named(tmp_path, make):
    writer = BagWriter(tmp_path / "bag", BagOptions(max_bagfile_duration=1.0))
    writer.add_topic("/text", TEXT)
    writer.write("/text", 0, make.text("first"))
    (tmp_path / "bag" / "bag_1.mcap").mkdir()
    with pytest.raises(RecordingError, match=r"bag_1\.mcap: cannot be written \(File exists\)"):
        writer.write("/text", SECOND, make.text("second"))
    assert not writer.is_open
    assert texts(BagReader(tmp_path / "bag" / "bag_0.mcap"), "/text") == ["first"]


def test_times_of_files_rise(split):
    files = BagReader(split).files
    assert all(before.end_ns < after.start_ns for before, after in itertools.pairwise(files))
