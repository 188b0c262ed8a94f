import pytest
import yaml
from rosbags.rosbag2.metadata import parse_qos

from roadmend.core.errors import InputError
from roadmend.recording import qos
from roadmend.recording.definitions import find
from roadmend.recording.layout import files_of
from roadmend.recording.qos import INFINITE_NS, Qos
from roadmend.recording.writer import BagWriter

INFINITE = {"sec": 9223372036, "nsec": 854775807}
LATCHED_SHAPE = {
    "history": "keep_last",
    "depth": 1,
    "reliability": "reliable",
    "durability": "transient_local",
    "deadline": {"sec": 0, "nsec": 500_000_000},
    "lifespan": INFINITE,
    "liveliness": "automatic",
    "liveliness_lease_duration": INFINITE,
    "avoid_ros_namespace_conventions": False,
}


def test_metadata_field_by_field(corpus):
    folder, written = corpus
    document = yaml.safe_load((folder / "metadata.yaml").read_text("utf-8"))
    assert list(document) == ["rosbag2_bagfile_information"]
    information = document["rosbag2_bagfile_information"]
    assert list(information) == [
        "version",
        "storage_identifier",
        "duration",
        "starting_time",
        "message_count",
        "topics_with_message_count",
        "compression_format",
        "compression_mode",
        "relative_file_paths",
        "files",
        "custom_data",
        "ros_distro",
    ]
    start, end = min(time for _, time, _ in written), max(time for _, time, _ in written)
    span = {
        "duration": {"nanoseconds": end - start},
        "starting_time": {"nanoseconds_since_epoch": start},
        "message_count": len(written),
    }
    assert information | span == information
    assert information["version"] == 9
    assert information["storage_identifier"] == "mcap"
    assert information["compression_format"] == information["compression_mode"] == ""
    assert information["relative_file_paths"] == ["corpus_0.mcap"]
    assert information["files"] == [{"path": "corpus_0.mcap", **span}]
    assert information["custom_data"] is None
    assert information["ros_distro"] == "jazzy"
    topics = {entry["topic_metadata"]["name"]: entry for entry in information["topics_with_message_count"]}
    assert {name: entry["message_count"] for name, entry in topics.items() if entry["message_count"] != 30} == {
        "/silent": 0
    }
    assert topics["/route"]["topic_metadata"] == {
        "name": "/route",
        "type": "roadmend_msgs/msg/Route",
        "serialization_format": "cdr",
        "offered_qos_profiles": [LATCHED_SHAPE],
        "type_description_hash": find("roadmend_msgs/msg/Route").type_hash,
    }
    assert len(topics["/events"]["topic_metadata"]["offered_qos_profiles"]) == 2


def test_metadata_have_no_yaml_anchors_and_nothing_is_left_beside(corpus):
    folder, _ = corpus
    assert not {"&", "*"} & set((folder / "metadata.yaml").read_text("utf-8"))
    assert sorted(path.name for path in folder.iterdir()) == ["corpus_0.mcap", "metadata.yaml"]


def test_an_empty_bag_starts_as_rosbag2_has_it(tmp_path):
    BagWriter(tmp_path / "empty").close()
    information = yaml.safe_load((tmp_path / "empty" / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert information["starting_time"] == {"nanoseconds_since_epoch": INFINITE_NS}
    assert information["duration"] == {"nanoseconds": 0}
    assert information["topics_with_message_count"] == []


def test_qos_text_is_what_rosbag2_writes_and_others_parse():
    offer = Qos(depth=1, durability="transient_local", deadline_ns=500_000_000)
    text = qos.dump([offer])
    assert text.startswith("- history: keep_last\n  depth: 1\n  reliability: reliable\n  durability: transient_local\n")
    assert yaml.safe_load(text) == [LATCHED_SHAPE]
    assert qos.load(text) == (offer,)
    (parsed,) = parse_qos(text)
    assert parsed.durability.name == "TRANSIENT_LOCAL"
    assert parsed.deadline == (0, 500_000_000)


@pytest.mark.parametrize("value", ["many", "[1]", "{}", "null"])
def test_a_duration_that_is_no_number_is_an_error(value):
    with pytest.raises((ValueError, TypeError)):
        qos.load(qos.dump([Qos()]).replace("sec: 9223372036", f"sec: {value}"))


def test_no_offers_are_an_empty_text():
    assert qos.dump([]) == ""
    assert qos.load("") == ()


def test_a_single_file_is_a_bag(corpus):
    folder, _ = corpus
    assert files_of(folder / "corpus_0.mcap") == files_of(folder)


def test_nothing_there(tmp_path):
    with pytest.raises(InputError, match="there is no such bag"):
        files_of(tmp_path / "absent")


def test_metadata_missing(tmp_path):
    (tmp_path / "corpus_0.mcap").touch()
    with pytest.raises(InputError, match=r"metadata\.yaml: is missing; the recording was cut short"):
        files_of(tmp_path)


def test_a_folder_that_is_no_bag(tmp_path):
    with pytest.raises(InputError, match=f"{tmp_path}: is no bag: neither"):
        files_of(tmp_path)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[",
        "a: b",
        "rosbag2_bagfile_information: 3",
        "\xff",
        "rosbag2_bagfile_information: {storage_identifier: mcap}",
    ],
)
def test_metadata_that_describe_no_bag(tmp_path, text):
    (tmp_path / "metadata.yaml").write_bytes(text.encode("latin-1"))
    with pytest.raises(InputError, match=r"metadata\.yaml: does not describe a bag"):
        files_of(tmp_path)


def test_another_storage_is_named(tmp_path):
    (tmp_path / "metadata.yaml").write_text(
        "rosbag2_bagfile_information: {storage_identifier: sqlite3, relative_file_paths: [a.db3]}"
    )
    with pytest.raises(InputError, match="the bag's storage is 'sqlite3'; turn it into one of mcap"):
        files_of(tmp_path)
