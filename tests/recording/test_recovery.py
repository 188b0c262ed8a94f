"""What comes back of bags that were cut, damaged, or never of ours."""

import contextlib
import json
import struct

import numpy as np
import pytest
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer
from rosbags.highlevel import AnyReader

from roadmend.core.errors import InputError
from roadmend.recording import recovery
from roadmend.recording.definitions import find
from roadmend.recording.info import bag_info
from roadmend.recording.qos import Qos
from roadmend.recording.reader import BagReader
from roadmend.recording.recovery import recover
from roadmend.recording.scan import Scan, ScannedMessage
from roadmend.recording.writer import BagOptions, BagWriter, Compression

TEXT = "std_msgs/msg/String"
COUNT = 200


@pytest.fixture
def written(tmp_path, make):
    """A bag of five chunks and what it holds, as (topic, time, bytes)."""

    def write(compression=Compression.ZSTD):
        messages = []
        with BagWriter(tmp_path / "bag", BagOptions(compression, 1 << 24, 3600.0)) as writer:
            writer.add_topic("/a", TEXT)
            writer.add_topic("/b", TEXT)
            writer.add_metadata("roadmend", {"seed": "7"})
            for number in range(COUNT):
                text = "".join(map(chr, make.random.integers(97, 122, 10_000)))
                messages.append((f"/{'ab'[number % 2]}", number, make.text(text)))
                writer.write(*messages[-1])
                if number % 40 == 39:
                    writer.flush()
            writer.add_attachment("scenario.yaml", "application/yaml", b"name: merge\n")
        return tmp_path / "bag" / "bag_0.mcap", messages

    return write


def records_of(path):
    return [(record.topic, record.time_ns, record.data) for record in BagReader(path).records()]


def chunks_of(path):
    """Where each chunk's record begins and where it ends."""
    with path.open("rb") as stream:
        indexes = make_reader(stream).get_summary().chunk_indexes
    return [(one.chunk_start_offset, one.chunk_start_offset + one.chunk_length) for one in indexes]


def change(path, place, value):
    content = bytearray(path.read_bytes())
    content[place : place + len(value)] = value
    path.write_bytes(content)


def test_a_whole_bag_comes_back_as_it_was(corpus, tmp_path):
    folder, written = corpus
    recovery = recover(folder, tmp_path / "new")
    assert (recovery.missing, recovery.count) == ([], len(written))
    assert records_of(tmp_path / "new") == written
    before, after = BagReader(folder), BagReader(tmp_path / "new")
    assert after.metadata["roadmend"] == before.metadata["roadmend"]
    assert after.attachments == before.attachments
    assert {name: topic for name, topic in before.topics.items() if topic.count} == after.topics
    with AnyReader([tmp_path / "new"]) as reader:
        assert sum(1 for _ in reader.messages()) == len(written)


@pytest.mark.parametrize("compression", list(Compression))
def test_a_file_cut_anywhere_gives_all_messages_before_the_cut(written, tmp_path, compression):
    path, messages = written(compression)
    content = path.read_bytes()
    chunks = chunks_of(path)
    assert len(chunks) == 5
    cut = tmp_path / "cut.mcap"
    for place, size in enumerate(np.linspace(chunks[0][1], len(content) - 1, 12).astype(int)):
        cut.write_bytes(content[:size])
        recovery = recover(cut, tmp_path / f"new{place}")
        back = records_of(tmp_path / f"new{place}")
        assert back == messages[: len(back)]
        whole = 40 * sum(end <= size for _, end in chunks)
        assert whole <= len(back) <= whole + 40
        assert recovery.missing
        assert BagReader(tmp_path / f"new{place}").metadata["roadmend_recovery"]["missing"]


@pytest.mark.parametrize("compression", list(Compression))
def test_messages_of_a_chunk_that_was_cut_come_back(written, tmp_path, compression):
    path, messages = written(compression)
    begin, end = chunks_of(path)[2]
    path.write_bytes(path.read_bytes()[: (begin + end) // 2])
    recovery = recover(path, tmp_path / "new")
    back = records_of(tmp_path / "new")
    assert back == messages[: len(back)]
    assert 80 < len(back) < 120  # half of the chunk, by blocks of the compressor
    assert f"chunk at byte {begin}: it was cut; {len(back) - 80} messages of it are kept" in recovery.missing


def test_a_wrong_checksum_is_told_and_the_messages_are_kept(written, tmp_path):
    path, messages = written()
    begin, _ = chunks_of(path)[1]
    change(path, begin + 9 + 24, b"\x01\x02\x03\x04")
    recovery = recover(path, tmp_path / "new")
    assert records_of(tmp_path / "new") == messages
    assert recovery.missing == [
        f"chunk at byte {begin}: its checksum is wrong: what it holds may be altered; 40 messages of it are kept"
    ]


def test_behind_a_damaged_chunk_it_goes_on(written, tmp_path):
    path, messages = written()
    begin, end = chunks_of(path)[1]
    change(path, (begin + end) // 2, bytes(200))
    recovery = recover(path, tmp_path / "new")
    back = records_of(tmp_path / "new")
    lost = COUNT - len(back)
    assert 0 < lost <= 40
    assert back == messages[: 80 - lost] + messages[80:]
    assert any(line.startswith(f"chunk at byte {begin}: its compressed data are damaged") for line in recovery.missing)
    assert sum(int(line.split()[1]) for line in recovery.missing if line.endswith("messages are lost")) == lost


@pytest.mark.parametrize("compression", [Compression.LZ4, Compression.NONE])
def test_what_a_compressor_does_not_notice_the_checksum_does(written, tmp_path, compression):
    path, messages = written(compression)
    begin, end = chunks_of(path)[1]
    change(path, (begin + end) // 2, bytes(20))
    recovery = recover(path, tmp_path / "new")
    back = records_of(tmp_path / "new")
    assert (back[:40], back[80:]) == (messages[:40], messages[80:])
    assert len(back) == COUNT
    assert sum(kept == message for kept, message in zip(back, messages, strict=True)) == COUNT - 1
    assert recovery.missing == [
        f"chunk at byte {begin}: its checksum is wrong: what it holds may be altered; 40 messages of it are kept"
    ]


@pytest.mark.parametrize("length", [0, 7, 1 << 40, (1 << 64) - 1])
def test_a_damaged_length_costs_one_chunk_at_most(written, tmp_path, length):
    path, messages = written()
    begin, _ = chunks_of(path)[1]
    change(path, begin + 1, struct.pack("<Q", length))
    recover(path, tmp_path / "new")
    back = records_of(tmp_path / "new")
    assert set(back) >= {*messages[:40], *messages[80:]}
    assert len(back) == len(set(back))


def test_a_damaged_beginning_costs_nothing_that_the_index_names(written, tmp_path):
    path, messages = written()
    change(path, 0, bytes(30))
    recovery = recover(path, tmp_path / "new")
    assert records_of(tmp_path / "new") == messages
    assert "bytes are damaged" in recovery.missing[0]


def test_a_missing_index_costs_nothing(written, tmp_path):
    path, messages = written()
    path.write_bytes(path.read_bytes()[: chunks_of(path)[-1][1]])
    recovery = recover(path, tmp_path / "new")
    assert records_of(tmp_path / "new") == messages
    assert recovery.missing == ["the file has no end: its writer was stopped, or the file was cut"]


def test_flipped_bytes_anywhere_never_end_in_another_error(written, tmp_path):
    path, messages = written()
    content = path.read_bytes()
    random = np.random.default_rng(3)
    known = set(messages)
    for number in range(60):
        changed = bytearray(content)
        for place in random.choice(len(content), 3):
            changed[place] ^= int(random.integers(1, 256))
        path.write_bytes(changed)
        scan = Scan(path)
        with contextlib.suppress(InputError):
            found = [one for one in scan if isinstance(one, ScannedMessage)]
            kept = sum((one.topic.name, one.time_ns, one.data) in known for one in found)
            assert kept >= 80  # three flips cost three of the five chunks at most
            assert kept == COUNT or scan.report.missing, number


def test_a_bag_without_metadata_file_and_with_a_file_missing(tmp_path, make):
    with BagWriter(tmp_path / "bag", BagOptions(max_bagfile_duration=1.0)) as writer:
        writer.add_topic("/text", TEXT)
        for second in range(12):
            writer.write("/text", second * 10**9, make.text(f"{second}"))
    (tmp_path / "bag" / "bag_3.mcap").unlink()
    assert recover(tmp_path / "bag", tmp_path / "one").missing == ["bag_3.mcap is missing"]
    (tmp_path / "bag" / "metadata.yaml").unlink()
    (tmp_path / "bag" / "bag_5.mcap").write_bytes(b"")
    recovery = recover(tmp_path / "bag", tmp_path / "two")
    assert recovery.missing == ["metadata.yaml: is missing", "bag_5.mcap: is empty"]
    texts = [message.value.data for message in BagReader(tmp_path / "two").messages()]
    assert texts == ["0", "1", "2", "4", "6", "7", "8", "9", "10", "11"]


def test_a_bag_whose_messages_are_compressed_is_not_taken_for_one_of_damaged_metadata(tmp_path, make):
    with BagWriter(tmp_path / "bag") as writer:
        writer.add_topic("/text", TEXT)
        writer.write("/text", 0, make.text("squeezed"))
    metadata = tmp_path / "bag" / "metadata.yaml"
    metadata.write_text(metadata.read_text().replace("compression_mode: ''", "compression_mode: message"))
    for read in (lambda path: recover(path, tmp_path / "out"), bag_info):
        with pytest.raises(InputError, match="the bag is compressed by message; rewrite it with 'ros2 bag convert'"):
            read(tmp_path / "bag")
    assert not (tmp_path / "out").exists()


@pytest.fixture
def latched(tmp_path, make):
    """A bag of three files with four events, of which each further file repeats the last two; each write is a chunk."""
    offer = Qos(depth=2, durability="transient_local")
    with BagWriter(tmp_path / "bag", BagOptions(max_bagfile_duration=1.0)) as writer:
        writer.add_topic("/events", TEXT, [offer])
        writer.add_topic("/stream", TEXT)
        for number in range(9):
            writer.write("/stream", number * 400_000_000, make.text(f"tick {number}"))
            if number % 2 == 0:
                writer.write("/events", number * 400_000_000 + 1, make.text(f"event {number}"))
            writer.flush()
    assert len(list((tmp_path / "bag").glob("*.mcap"))) == 3
    return tmp_path / "bag"


def events_of(path):
    return [message.value.data for message in BagReader(path).messages(["/events"])]


def test_of_a_whole_bag_what_is_repeated_is_known_again(latched, tmp_path):
    recover(latched, tmp_path / "new")
    assert events_of(tmp_path / "new") == events_of(latched) == [f"event {number}" for number in (0, 2, 4, 6, 8)]
    assert BagReader(tmp_path / "new").topics["/events"].count == 5


def test_what_was_recovered_can_be_recovered_again_though_it_tells_of_repeats_behind_them(tmp_path, make, monkeypatch):
    short = BagOptions(chunk_size=1000, flush_interval=float("inf"), self_contained=False)
    monkeypatch.setattr(recovery, "_COPY", short)  # as a longer file would have more than one chunk
    with BagWriter(tmp_path / "bag", BagOptions(Compression.NONE, chunk_size=1000)) as writer:
        writer.add_topic("/events", TEXT, [Qos(depth=1, durability="transient_local")])
        writer.add_topic("/stream", TEXT)
        writer.write("/events", 0, make.text("event 0"))
        writer.split()
        for number in range(200):
            writer.write("/stream", number, make.text(f"{number}" * 20))
    for before, after in (("bag", "one"), ("one", "two"), ("two", "three")):
        recover(tmp_path / before, tmp_path / after)
        assert events_of(tmp_path / after) == ["event 0"]


def test_where_the_file_before_is_lost_what_the_next_repeats_is_all_that_there_is(latched, tmp_path):
    (latched / "bag_0.mcap").write_bytes(b"")
    recover(latched, tmp_path / "new")
    assert events_of(tmp_path / "new") == ["event 0", "event 2", "event 4", "event 6", "event 8"]


def test_where_the_repeated_are_lost_those_behind_them_are_not_taken_for_them(latched, tmp_path):
    begin, end = chunks_of(latched / "bag_1.mcap")[0]
    change(latched / "bag_1.mcap", (begin + end) // 2, bytes(30))
    recover(latched, tmp_path / "new")
    assert set(events_of(tmp_path / "new")) >= {"event 0", "event 2", "event 6", "event 8"}
    (latched / "bag_0.mcap").write_bytes(b"")
    recover(latched, tmp_path / "both")
    assert set(events_of(tmp_path / "both")) >= {"event 6", "event 8"}


def test_a_byte_that_looks_like_a_chunk_does_not_hide_the_one_behind_it(written, tmp_path):
    path, messages = written(Compression.NONE)
    (begin, _), (second, _) = chunks_of(path)[:2]
    change(path, begin + 1, struct.pack("<Q", 1 << 60))  # so that it looks for the next one
    change(path, second - 8, b"\x06")  # and finds this one in the bytes before it
    recover(path, tmp_path / "new")
    assert set(records_of(tmp_path / "new")) >= set(messages[40:])


def foreign(path, encoding, schema_encoding, **options):
    with path.open("wb") as stream:
        writer = Writer(stream, **options)
        writer.start(profile="")
        schema = writer.register_schema("std_msgs/msg/String", schema_encoding, find(TEXT).text.encode())
        channel = writer.register_channel("/foreign", encoding, schema)
        for number in range(5):
            writer.add_message(channel, number, json.dumps({"data": number}).encode(), number)
        writer.finish()


@pytest.mark.parametrize(
    ("encodings", "words"),
    [
        (("json", "jsonschema"), "its messages are json"),
        (("ros1", "ros1msg"), "its messages are ros1"),
        (("cdr", "omgidl"), "its definition is omgidl"),
    ],
)
def test_a_foreign_file_is_refused_with_the_reason(tmp_path, encodings, words):
    foreign(tmp_path / "foreign.mcap", *encodings)
    with pytest.raises(InputError, match=rf"holds no message that can be read: /foreign: left out, {words}; take"):
        recover(tmp_path / "foreign.mcap", tmp_path / "new")
    assert not (tmp_path / "new").exists()
    with pytest.raises(InputError, match=r"/foreign holds \w+ messages with \w+; take a bag of ROS 2"):
        BagReader(tmp_path / "foreign.mcap")


def written_otherwise(path, *channels):
    """A bag of another writer: of each channel its topic, type and definition, with a message of three numbers."""
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start("ros2")
        for number, (topic, type_name, text) in enumerate(channels):
            schema = writer.register_schema(type_name, "ros2msg", text)
            channel = writer.register_channel(topic, "cdr", schema, {"offered_qos_profiles": ""})
            data = b"\0\1\0\0" + np.array([1.0, 2.0, 3.0]).tobytes()
            writer.add_message(channel, 10 + number, data, 10 + number, 1)
        writer.finish()
    return path


POINT = "geometry_msgs/msg/Point"
XYZ, ZYX = b"float64 x\nfloat64 y\nfloat64 z\n", b"float64 z\nfloat64 y\nfloat64 x\n"


@pytest.mark.parametrize(
    ("other", "told"),
    [
        (("/t", "std_msgs/msg/Float64", b"float64 data\n"), "some are std_msgs/msg/Float64, those before them"),
        (("/other", POINT, ZYX), f"their {POINT} is another than that of /t"),
    ],
)
def test_what_would_pass_for_another_type_is_left_out_and_named(tmp_path, other, told):
    path = written_otherwise(tmp_path / "a.mcap", ("/t", POINT, XYZ), other)
    recovered = recover(path, tmp_path / "new")
    assert len(recovered.missing) == 1
    assert told in recovered.missing[0]
    (record,) = BagReader(tmp_path / "new").messages(["/t"])
    assert (record.value.x, record.value.z) == (1.0, 3.0)
    assert not bag_info(path).complete
    with pytest.raises(InputError, match=r"has two (types|definitions)"):
        BagReader(path)


def test_one_definition_in_other_words_is_one(tmp_path):
    channels = ("/t", POINT, XYZ), ("/u", POINT, b"# Where it is.\n" + XYZ)
    path = written_otherwise(tmp_path / "a.mcap", *channels)
    assert recover(path, tmp_path / "new").missing == []
    assert [record.value.z for record in BagReader(path).messages(["/t", "/u"])] == [3.0, 3.0]


@pytest.mark.parametrize("options", [{"use_chunking": False}, {"compression": CompressionType.NONE}])
def test_a_file_that_another_writer_laid_out_otherwise(tmp_path, options):
    foreign(tmp_path / "other.mcap", "cdr", "ros2msg", **options)
    assert recover(tmp_path / "other.mcap", tmp_path / "new").missing == []
    assert BagReader(tmp_path / "new").count == 5


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "is empty; there is nothing to recover"),
        (b"\x89MCAP0\r\n", "holds no message that can be read: the file has no end"),
        (b"some other file that is long enough" * 9, "is no MCAP file; take another file"),
        (b"#ROSBAG V2.0\n" + bytes(99), "is a bag of ROS 1; turn it into one of ROS 2 with 'rosbags-convert'"),
        (b"SQLite format 3\x00" + bytes(99), "is the database of a sqlite3 bag; turn its folder into mcap"),
    ],
)
def test_what_holds_nothing_is_refused_in_one_line(tmp_path, content, words):
    (tmp_path / "x.mcap").write_bytes(content)
    with pytest.raises(InputError, match=words):
        recover(tmp_path / "x.mcap", tmp_path / "new")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["x.mcap"]


def test_a_folder_without_bag_and_a_place_that_is_taken(tmp_path, corpus):
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match="empty: is no bag"):
        recover(tmp_path / "empty", tmp_path / "new")
    with pytest.raises(InputError, match="there is no such bag"):
        recover(tmp_path / "absent", tmp_path / "new")
    with pytest.raises(InputError, match="empty: exists already"):
        recover(corpus[0], tmp_path / "empty")


def test_a_message_that_claims_to_be_huge_is_damage(tmp_path, make):
    with BagWriter(tmp_path / "bag", BagOptions(Compression.NONE)) as writer:
        writer.add_topic("/text", TEXT)
        for number in range(3):
            writer.write("/text", number, make.text("x" * 100))
    path = tmp_path / "bag" / "bag_0.mcap"
    second = path.read_bytes().index(struct.pack("<BQHI", Opcode.MESSAGE, 131, 1, 2))
    change(path, second + 1, struct.pack("<Q", 1 << 50))
    recovery = recover(path, tmp_path / "new")
    assert recovery.count == 1
    assert "/text: 2 of 3 messages are lost" in recovery.missing
