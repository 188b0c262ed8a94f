"""From mcap to sqlite3 and back, read by the library rosbags."""

import sqlite3

import pytest
from rosbags.highlevel import AnyReader
from rosbags.interfaces import Qos as RosbagsQos
from rosbags.interfaces import QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime
from rosbags.rosbag2 import Reader, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from roadmend.cli.main import main
from roadmend.core.errors import InputError
from roadmend.recording import qos
from roadmend.recording.conversion import convert, storage_of
from roadmend.recording.qos import Qos
from roadmend.recording.reader import BagReader
from roadmend.recording.writer import BagOptions, BagWriter


def contents(path):
    """What the library rosbags reads: messages, and of each topic its type, hash and offers."""
    with Reader(path) as reader:
        messages = [(connection.topic, time_ns, bytes(data)) for connection, time_ns, data in reader.messages()]
        topics = {one.topic: (one.msgtype, one.digest, one.ext.offered_qos_profiles) for one in reader.connections}
    return messages, topics


def test_there_and_back(corpus, tmp_path):
    folder, written = corpus
    there = convert(folder, tmp_path / "sql", "sqlite3")
    assert (there.messages, there.left_out) == (len(written), ["attachment scenario.yaml: sqlite3 has no place for it"])
    assert storage_of(tmp_path / "sql") == "sqlite3"
    assert sorted(path.name for path in (tmp_path / "sql").iterdir()) == ["metadata.yaml", "sql.db3"]
    messages, topics = contents(tmp_path / "sql")
    original, original_topics = contents(folder)
    assert messages == original == written
    assert topics == {name: one for name, one in original_topics.items() if name != "/silent"}
    back = convert(tmp_path / "sql", tmp_path / "back", "mcap")
    assert (back.messages, back.left_out) == (len(written), [])
    before, after = BagReader(folder), BagReader(tmp_path / "back")
    assert [(record.topic, record.time_ns, record.data) for record in after.records()] == written
    assert (after.topics, after.definitions) == (before.topics, before.definitions)
    assert after.metadata["roadmend"] == before.metadata["roadmend"]


def test_the_database_is_one_that_is_sound(corpus, tmp_path):
    convert(corpus[0], tmp_path / "sql", "sqlite3")
    with sqlite3.connect(tmp_path / "sql" / "sql.db3") as database:
        assert database.execute("PRAGMA integrity_check").fetchone() == ("ok",)
        assert database.execute("SELECT COUNT(*) FROM messages").fetchone() == (len(corpus[1]),)


def test_a_database_of_another_writer(tmp_path):
    store = get_typestore(Stores.ROS2_JAZZY)
    text = store.types["std_msgs/msg/String"]
    endless = QosTime(9223372036, 854775807)
    offer = RosbagsQos(
        QosHistory.KEEP_LAST,
        7,
        QosReliability.BEST_EFFORT,
        QosDurability.TRANSIENT_LOCAL,
        endless,
        endless,
        QosLiveliness.AUTOMATIC,
        endless,
        False,
    )
    with Writer(tmp_path / "theirs", version=8, storage_plugin=StoragePlugin.SQLITE3) as writer:
        connection = writer.add_connection(
            "/text", "std_msgs/msg/String", typestore=store, offered_qos_profiles=[offer]
        )
        for number in range(5):
            data = store.serialize_cdr(text(data=f"{number}"), "std_msgs/msg/String")
            writer.write(connection, number * 10, data)
        writer.set_custom_data("robot", "r2")
    for number, source in enumerate(["theirs", "theirs/metadata.yaml", "theirs/theirs.db3"]):
        convert(tmp_path / source, tmp_path / f"ours{number}", "mcap")
        reader = BagReader(tmp_path / f"ours{number}")
        assert [message.value.data for message in reader.messages()] == ["0", "1", "2", "3", "4"]
        assert reader.topics["/text"].offers == (Qos(depth=7, reliability="best_effort", durability="transient_local"),)
    assert BagReader(tmp_path / "ours0").metadata["custom_data"] == {"robot": "r2"}
    with AnyReader([tmp_path / "ours0"]) as reader:
        assert [reader.deserialize(data, "std_msgs/msg/String").data for _, _, data in reader.messages()] == [*"01234"]


def test_a_split_bag_becomes_one_database_without_the_repeated_messages(tmp_path, make):
    with BagWriter(tmp_path / "bag", BagOptions(max_bagfile_duration=1.0)) as writer:
        writer.add_topic("/latched", "std_msgs/msg/String", [Qos(depth=1, durability="transient_local")])
        writer.add_topic("/text", "std_msgs/msg/String", [Qos()])
        writer.write("/latched", 0, make.text("once"))
        for second in range(3):
            writer.write("/text", second * 10**9, make.text(f"{second}"))
    assert convert(tmp_path / "bag", tmp_path / "sql", "sqlite3").messages == 4


def test_offers_survive_the_library():
    offer = Qos("keep_all", 3, "best_effort", "transient_local", 5, 10**9 + 1, "manual_by_topic", 7, True)
    assert qos.from_rosbags(qos.to_rosbags(offer)) == offer


def test_offers_of_older_bags_are_numbers():
    text = qos.dump([Qos()]).replace("keep_last", "2").replace("reliable", "2").replace("volatile", "1")
    (offer,) = qos.load(text.replace("automatic", "3"))
    assert offer == Qos("keep_all", 10, "best_effort", "transient_local", liveliness="manual_by_topic")


def database(folder, content):
    folder.mkdir()
    (folder / "bag.db3").write_bytes(content)
    return folder / "bag.db3"


@pytest.mark.parametrize("content", [b"", b"SQLite format 3\x00" + bytes(2000), b"nothing of the kind" * 99])
def test_a_database_that_is_none(tmp_path, content):
    path = database(tmp_path / "bad", content)
    with pytest.raises(InputError, match=r"bag\.db3: cannot be read \(.+\); take another bag"):
        convert(path, tmp_path / "new", "mcap")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bad"]


def test_times_that_no_bag_of_ros_2_can_say_are_refused_in_a_line(tmp_path, make):
    with BagWriter(tmp_path / "late") as writer:
        writer.add_topic("/t", "std_msgs/msg/String")
        writer.write("/t", 1 << 63, make.cdr(make("std_msgs/msg/String")))
    with pytest.raises(InputError, match=r"has messages later than a bag of ROS 2 can say; .*recover"):
        convert(tmp_path / "late", tmp_path / "sql", "sqlite3")
    assert not (tmp_path / "sql").exists()


@pytest.mark.parametrize("mode", ["message", "file"])
@pytest.mark.parametrize("given", ["", "metadata.yaml", "sql.db3"])
def test_a_database_that_is_compressed_as_a_whole_is_refused_unread(corpus, tmp_path, mode, given):
    convert(corpus[0], tmp_path / "sql", "sqlite3")
    metadata = tmp_path / "sql" / "metadata.yaml"
    text = metadata.read_text("utf-8")
    text = text.replace("compression_format: ''", "compression_format: zstd")
    metadata.write_text(text.replace("compression_mode: ''", f"compression_mode: {mode}"), "utf-8")
    with pytest.raises(InputError, match=f"the bag is compressed by {mode}"):
        convert(tmp_path / "sql" / given, tmp_path / "back", "mcap")
    assert not (tmp_path / "back").exists()


def test_what_needs_no_conversion_or_allows_none(corpus, tmp_path):
    folder, _ = corpus
    with pytest.raises(InputError, match="is a bag of mcap already; choose the other storage"):
        convert(folder, tmp_path / "new", "mcap")
    with pytest.raises(InputError, match="there is no such bag"):
        convert(tmp_path / "absent", tmp_path / "new", "mcap")
    (tmp_path / "taken").mkdir()
    with pytest.raises(InputError, match="taken: exists already"):
        convert(folder, tmp_path / "taken", "sqlite3")
    (folder / "metadata.yaml").write_text(
        "rosbag2_bagfile_information: {storage_identifier: tape, relative_file_paths: [a.tape]}"
    )
    with pytest.raises(InputError, match="the bag's storage is 'tape'; take one of mcap or sqlite3"):
        storage_of(folder)


def test_the_command_chooses_the_other_storage(corpus, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["bag", "convert", str(corpus[0])]) == 0
    assert "corpus-sqlite3: 360 messages in sqlite3\nleft out: attachment scenario.yaml" in capsys.readouterr().out
    assert main(["bag", "convert", "corpus-sqlite3", "--out", "again"]) == 0
    assert main(["bag", "diff", str(corpus[0]), "again", "--exclude", ""]) == 0
    assert main(["bag", "convert", "again", "--to", "mcap"]) == 2


def test_a_word_that_is_no_quality_of_service_is_refused_before_anything_is_written(tmp_path, make):
    with BagWriter(tmp_path / "bag") as writer:
        writer.add_topic("/text", "std_msgs/msg/String", [Qos(history="banana")])
        writer.write("/text", 0, make.text("x"))
    with pytest.raises(InputError, match="'banana' is no quality of service"):
        convert(tmp_path / "bag", tmp_path / "new", "sqlite3")
    assert not (tmp_path / "new").exists()


def test_times_of_sending_and_numbers_that_sqlite3_has_no_place_for_are_named(tmp_path, make):
    with BagWriter(tmp_path / "bag") as writer:
        writer.add_topic("/text", "std_msgs/msg/String", [Qos()])
        for number in range(4):
            writer.write(
                "/text", 10 * number, make.text("x"), publish_ns=10 * number - (number > 1), sequence=number + 1
            )
        writer.write("/text", 50, make.text("x"), sequence=9)
    told = convert(tmp_path / "bag", tmp_path / "sql", "sqlite3").left_out
    assert told == [
        "2 publish times: sqlite3 has no place for them",
        "1 sequence numbers: sqlite3 has no place for them",
    ]
