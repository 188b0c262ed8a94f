"""Bags of ours, read by readers that we did not write."""

import contextlib
import json
import shutil
import struct
import subprocess
from collections import Counter
from io import BytesIO
from pathlib import Path

import pytest
import yaml
import zstandard
from mcap.exceptions import EndOfFile
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.records import Channel, Chunk, ChunkIndex, DataEnd, Footer, Header, MessageIndex, Schema, Statistics
from mcap.stream_reader import StreamReader
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import Reader

from roadmend.recording.definitions import find
from roadmend.recording.qos import Qos
from roadmend.recording.reader import BagReader
from roadmend.recording.recovery import recover
from roadmend.recording.writer import BagWriter

NPM = Path(__file__).parents[1] / "npm"


def test_rosbags_reads_the_same(corpus, make, plain):
    folder, written = corpus
    with AnyReader([folder]) as reader:
        assert reader.message_count == len(written)
        read = [
            (connection.topic, time_ns, plain(reader.deserialize(data, connection.msgtype)))
            for connection, time_ns, data in reader.messages()
        ]
        types = {connection.topic: connection.msgtype for connection in reader.connections}
    expected = [
        (topic, time_ns, plain(make.store.deserialize_cdr(data, types[topic]))) for topic, time_ns, data in written
    ]
    key = json.dumps
    assert sorted(map(key, read)) == sorted(map(key, expected))


def test_rosbags_reads_the_layout(corpus):
    folder, written = corpus
    with Reader(folder) as reader:
        assert reader.message_count == len(written)
        assert reader.start_time == written[0][1]
        assert reader.end_time == written[-1][1] + 1
        events = next(one for one in reader.connections if one.topic == "/events")
        assert [profile.durability.name for profile in events.ext.offered_qos_profiles] == [
            "VOLATILE",
            "TRANSIENT_LOCAL",
        ]
        assert events.digest == find("roadmend_msgs/msg/ScenarioEvent").type_hash


def test_rosbags_reads_all_of_a_topic_whose_publishers_changed(tmp_path, make):
    def announce(bag, *offers):
        bag.add_topic("/text", "std_msgs/msg/String", offers)

    text = bytes(make.store.serialize_cdr(make("std_msgs/msg/String"), "std_msgs/msg/String"))
    with BagWriter(tmp_path / "bag") as bag:
        announce(bag)
        announce(bag, Qos())  # none of its messages has come yet
        bag.write("/text", 1, text)
        announce(bag, Qos(), Qos(durability="transient_local"))  # another publisher
        bag.write("/text", 2, text)
    with AnyReader([tmp_path / "bag"]) as reader:
        assert [time_ns for _, time_ns, _ in reader.messages()] == [1, 2]
    assert BagReader(tmp_path / "bag").topics["/text"].offers == (Qos(),)


def test_mcap_reads_the_same(corpus):
    folder, written = corpus
    with (folder / "corpus_0.mcap").open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        read = [
            (channel.topic, message.log_time, message.publish_time, message.data)
            for _, channel, message in reader.iter_messages()
        ]
        sequences = [message.sequence for _, channel, message in reader.iter_messages("/ego")]
        names = [metadata.name for metadata in reader.iter_metadata()]
    assert read == [(topic, time_ns, time_ns, data) for topic, time_ns, data in written]
    assert sequences == list(range(1, 31))
    assert names == ["roadmend", "roadmend", "rosbag2"]


def test_the_file_repeats_what_metadata_yaml_says(corpus):
    folder, _ = corpus
    with (folder / "corpus_0.mcap").open("rb") as stream:
        inside = next(one for one in make_reader(stream).iter_metadata() if one.name == "rosbag2")
    outside = yaml.safe_load((folder / "metadata.yaml").read_text("utf-8"))["rosbag2_bagfile_information"]
    assert yaml.safe_load(inside.metadata["serialized_metadata"]) == outside


def test_every_record_is_in_its_place(corpus):
    """What the MCAP specification asks for, record by record."""
    folder, written = corpus
    path = folder / "corpus_0.mcap"
    content = path.read_bytes()
    with path.open("rb") as stream:
        records = list(StreamReader(stream, emit_chunks=True, validate_crcs=True).records)
    header, footer = records[0], records[-1]
    assert isinstance(header, Header)
    assert header.profile == "ros2"
    assert isinstance(footer, Footer)
    assert footer.summary_crc != 0
    end = next(place for place, record in enumerate(records) if isinstance(record, DataEnd))
    data, summary = records[:end], records[end + 1 :]
    chunks = [record for record in data if isinstance(record, Chunk)]
    indexes = [record for record in summary if isinstance(record, ChunkIndex)]
    assert len(chunks) == len(indexes) >= 2
    found = Counter()
    channels, schemas = {}, {}
    for chunk, index in zip(chunks, indexes, strict=True):
        assert content[index.chunk_start_offset] == Opcode.CHUNK
        assert (chunk.message_start_time, chunk.message_end_time) == (index.message_start_time, index.message_end_time)
        assert chunk.compression == index.compression == "zstd"
        assert chunk.uncompressed_crc != 0
        inside = zstandard.decompress(chunk.data, max_output_size=chunk.uncompressed_size)
        assert len(inside) == chunk.uncompressed_size == index.uncompressed_size
        with contextlib.suppress(EndOfFile):  # a chunk ends without a footer
            for record in StreamReader(BytesIO(inside), skip_magic=True).records:
                if isinstance(record, Channel):
                    channels[record.id] = record
                    assert record.schema_id in schemas
                if isinstance(record, Schema):
                    schemas[record.id] = record
        for channel, offset in index.message_index_offsets.items():
            entry = next(StreamReader(BytesIO(content[offset:]), skip_magic=True).records)
            assert isinstance(entry, MessageIndex)
            assert entry.channel_id == channel
            for time_ns, place in entry.records:
                opcode, _, channel_id, _, log_time = struct.unpack_from("<BQHIQ", inside, place)
                assert (opcode, channel_id, log_time) == (Opcode.MESSAGE, channel, time_ns)
                found[channel] += 1
    statistics = next(record for record in summary if isinstance(record, Statistics))
    assert statistics.channel_message_counts == found
    assert statistics.message_count == found.total() == len(written)
    assert (statistics.chunk_count, statistics.attachment_count, statistics.metadata_count) == (len(chunks), 1, 3)
    assert {record.id: record for record in summary if isinstance(record, Channel)} == channels
    assert {record.id: record for record in summary if isinstance(record, Schema)} == schemas
    for channel in channels.values():
        assert channel.message_encoding == "cdr"
        assert set(channel.metadata) == {"offered_qos_profiles", "topic_type_hash"}
        assert schemas[channel.schema_id].encoding == "ros2msg"


def javascript(path):
    """What the JavaScript libraries read, as parsed JSON."""
    if shutil.which("node") is None or not (NPM / "node_modules").is_dir():
        pytest.skip("node or tests/npm/node_modules is not there")
    done = subprocess.run(
        ["node", NPM / "read_bag.mjs", path], capture_output=True, text=True, check=False, timeout=120
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def numbers_as_text(value):
    """64-bit integers reach JSON as texts from JavaScript: make all whole numbers texts on both sides."""
    if isinstance(value, dict):
        return {name: numbers_as_text(one) for name, one in value.items()}
    if isinstance(value, list):
        return [numbers_as_text(one) for one in value]
    if isinstance(value, float) and value.is_integer():
        value = int(value)
    return str(value) if isinstance(value, int) and not isinstance(value, bool) else value


def test_javascript_reads_the_same(corpus, make, plain):
    folder, written = corpus
    read = javascript(folder / "corpus_0.mcap")
    assert read["profile"] == "ros2"
    types = {channel["topic"]: channel["type"] for channel in read["channels"]}
    assert {channel["topic"]: channel["count"] for channel in read["channels"]} == dict.fromkeys(types, "30")
    assert len(read["messages"]) == len(written)
    for message, (topic, time_ns, data) in zip(read["messages"], written, strict=True):
        assert (message["topic"], message["time"], message["publishTime"]) == (topic, str(time_ns), str(time_ns))
        expected = plain(make.store.deserialize_cdr(data, types[topic]))
        assert numbers_as_text(message["value"]) == numbers_as_text(expected), topic
    events = next(channel for channel in read["channels"] if channel["topic"] == "/events")
    offers = yaml.safe_load(events["metadata"]["offered_qos_profiles"])
    assert [offer["durability"] for offer in offers] == ["volatile", "transient_local"]
    assert read["metadata"][0] == {"name": "roadmend", "values": {"seed": "7", "outcome": "UNFINISHED"}}
    assert read["attachments"] == [
        {"name": "scenario.yaml", "mediaType": "application/yaml", "text": "name: merge ✓\n"}
    ]


def test_javascript_reads_a_bag_without_messages(tmp_path):
    with BagWriter(tmp_path / "bag") as writer:
        writer.add_topic("/silent", "std_msgs/msg/String")
    assert javascript(tmp_path / "bag" / "bag_0.mcap")["messages"] == []


def test_rosbags_reads_a_bag_without_messages(tmp_path):
    with BagWriter(tmp_path / "bag") as writer:
        writer.add_topic("/silent", "std_msgs/msg/String")
    with Reader(tmp_path / "bag") as reader:
        assert list(reader.messages()) == []


@pytest.fixture
def recovered(corpus, tmp_path):
    """A bag brought back from one that was cut in the middle, and what it must hold."""
    folder, written = corpus
    path = folder / "corpus_0.mcap"
    with path.open("rb") as stream:
        last = make_reader(stream).get_summary().chunk_indexes[-1]
    path.write_bytes(path.read_bytes()[: last.chunk_start_offset + last.chunk_length - 100])
    recovery = recover(path, tmp_path / "recovered")
    assert len(written) // 2 <= recovery.count < len(written)
    return tmp_path / "recovered", written[: recovery.count]


@pytest.fixture(params=["split_corpus", "recovered"])
def bag(request):
    return request.getfixturevalue(request.param)


def test_every_reader_reads_split_and_recovered_bags_alike(bag, make, plain):
    folder, written = bag
    files = sorted(folder.glob("*.mcap"))
    by_mcap, by_javascript = [], []
    for file in files:
        with file.open("rb") as stream:
            reader = make_reader(stream, validate_crcs=True)
            by_mcap += [(one.topic, message.log_time, message.data) for _, one, message in reader.iter_messages()]
        by_javascript += javascript(file)["messages"]
    with Reader(folder) as reader:
        by_rosbags = [(one.topic, time_ns, data) for one, time_ns, data in reader.messages()]
        types = {one.topic: one.msgtype for one in reader.connections}
        assert reader.message_count == len(by_rosbags)
    assert by_rosbags == by_mcap
    # What is latched stands once more at the start of each further file.
    route = next(data for topic, _, data in written if topic == "/route")
    repeats = Counter({("/route", route): len(files) - 1})
    assert Counter((topic, data) for topic, _, data in by_mcap) - repeats == Counter(
        (topic, data) for topic, _, data in written
    )
    assert [(one["topic"], one["time"]) for one in by_javascript] == [(topic, str(time)) for topic, time, _ in by_mcap]
    for message, (topic, _, data) in zip(by_javascript, by_mcap, strict=True):
        expected = plain(make.store.deserialize_cdr(data, types[topic]))
        assert numbers_as_text(message["value"]) == numbers_as_text(expected), topic
