"""The folder that makes an MCAP file a rosbag2 bag: NAME/NAME_0.mcap and NAME/metadata.yaml (version 9)."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from roadmend.core.bounded_file import open_regular
from roadmend.core.errors import InputError
from roadmend.core.yaml_file import read_yaml
from roadmend.recording.qos import Qos

TIME_LIMIT = 1 << 63  # [ns] rosbag2 has no later times
METADATA_FILE = "metadata.yaml"
RECORD = "roadmend"  # metadata record of the run: who drove what, and what came of it
FILE_RECORD = "rosbag2"  # metadata record of the file itself, which every writer makes anew
REPEATED = "roadmend_repeated"  # metadata record of a further file: by topic, which messages repeat earlier ones
_ROOT = "rosbag2_bagfile_information"
_VERSION = 9
_DISTRO = "jazzy"
_NO_START = 2**63 - 1  # [ns] what rosbag2 writes as the start of a bag without messages


@dataclass(frozen=True, slots=True)
class TopicSummary:
    """What a bag holds of one topic."""

    name: str
    type_name: str  # package/msg/Name
    type_hash: str
    offers: tuple[Qos, ...]
    count: int


@dataclass(frozen=True, slots=True)
class FileSummary:
    """What one file of a bag holds; times are log times [ns], meaningless where count is 0."""

    name: str
    count: int
    start_ns: int
    end_ns: int

    @property
    def span(self) -> dict[str, Any]:
        """Start, duration and count in rosbag2's shape."""
        start, duration = (self.start_ns, self.end_ns - self.start_ns) if self.count else (_NO_START, 0)
        return {
            "starting_time": {"nanoseconds_since_epoch": start},
            "duration": {"nanoseconds": duration},
            "message_count": self.count,
        }


def bag_information(files: Sequence[FileSummary], topics: Sequence[TopicSummary]) -> dict[str, Any]:
    """The bag as rosbag2 jazzy describes it, key by key and in its order."""
    filled = [file for file in files if file.count]
    whole = FileSummary(
        "",
        sum(file.count for file in filled),
        min((file.start_ns for file in filled), default=0),
        max((file.end_ns for file in filled), default=0),
    )
    span = whole.span
    return {
        "version": _VERSION,
        "storage_identifier": "mcap",
        "duration": span["duration"],
        "starting_time": span["starting_time"],
        "message_count": span["message_count"],
        "topics_with_message_count": [
            {
                "topic_metadata": {
                    "name": topic.name,
                    "type": topic.type_name,
                    "serialization_format": "cdr",
                    "offered_qos_profiles": [offer.as_yaml() for offer in topic.offers],
                    "type_description_hash": topic.type_hash,
                },
                "message_count": topic.count,
            }
            for topic in topics
        ],
        "compression_format": "",  # chunks are compressed, which is the file's own business
        "compression_mode": "",
        "relative_file_paths": [file.name for file in files],
        "files": [{"path": file.name, **file.span} for file in files],
        "custom_data": None,
        "ros_distro": _DISTRO,
    }


def as_text(information: dict[str, Any]) -> str:
    """YAML text of a part of the metadata."""
    return yaml.dump(information, Dumper=_Dumper, sort_keys=False, allow_unicode=True)


def write_metadata(folder: Path, information: dict[str, Any]) -> None:
    """Write ``metadata.yaml`` beside its place and move it there, so that it is never there in part.

    Raises:
        OSError: the folder cannot be written.
    """
    beside = folder / f".{METADATA_FILE}.part"
    beside.write_text(as_text({_ROOT: information}), "utf-8")
    beside.replace(folder / METADATA_FILE)


def files_of(path: Path) -> list[Path]:
    """The MCAP files of a bag, in order.

    Args:
        path: a bag's folder, its metadata.yaml, or an MCAP file by itself.

    Raises:
        InputError: nothing is there, the metadata are missing or unusable, or the bag is of another kind.
    """
    if path.exists() and not path.is_dir() and path.name != METADATA_FILE:
        refuse_foreign(path)
        return [path]
    information = read_metadata(path)
    metadata = folder_of(path) / METADATA_FILE
    if information["storage_identifier"] != "mcap":
        raise InputError(
            str(metadata),
            f"the bag's storage is {information['storage_identifier']!r}",
            "turn it into one of mcap with 'roadmend bag convert'",
        )
    refuse_compressed(path)
    return [metadata.parent / name for name in information["relative_file_paths"]]


def is_compressed(path: Path) -> bool:
    """Whether the metadata of a bag say that its messages, or its files, are compressed as a whole, as rosbag2 does it.

    Args:
        path: a bag's folder, or its metadata.yaml; False where that cannot be read.
    """
    try:
        return bool(read_metadata(path).get("compression_mode"))
    except InputError:
        return False


def refuse_compressed(path: Path) -> None:
    """Refuse a bag whose messages or files are compressed as a whole: nobody bounds what they unpack to.

    Args:
        path: a bag's folder, or its metadata.yaml.

    Raises:
        InputError: it is one.
    """
    if is_compressed(path):
        mode = read_metadata(path)["compression_mode"]
        mend = "rewrite it with 'ros2 bag convert', without compression_mode"
        raise InputError(str(folder_of(path) / METADATA_FILE), f"the bag is compressed by {mode}", mend)


def promised_counts(path: Path) -> dict[str, int]:
    """How many messages each topic of a bag has by its metadata.

    Args:
        path: a bag's folder, or its metadata.yaml; nothing is promised where that cannot be read, and of a file by itself.
    """
    if not path.is_dir() and path.name != METADATA_FILE:
        return {}
    try:
        topics = read_metadata(path)["topics_with_message_count"]
        return {str(topic["topic_metadata"]["name"]): int(topic["message_count"]) for topic in topics}
    except (InputError, KeyError, TypeError, ValueError):
        return {}


def folder_of(path: Path) -> Path:
    """The folder of a bag that is named by its folder, its metadata.yaml or a file of its own."""
    return path if path.is_dir() else path.parent


def read_metadata(path: Path) -> dict[str, Any]:
    """What metadata.yaml says of a bag: at least the storage and the files, as texts.

    Args:
        path: a bag's folder, or its metadata.yaml.

    Raises:
        InputError: nothing is there, or the file is missing or unusable.
    """
    if not path.exists():
        raise InputError(str(path), "there is no such bag", "name a bag's folder or an .mcap file")
    if not path.is_dir():
        refuse_foreign(path)  # a FIFO beside a bag is not that bag
    metadata = folder_of(path) / METADATA_FILE
    try:
        information: dict[str, Any] = read_yaml(metadata)[_ROOT]
        names = [str(name) for name in information["relative_file_paths"]]
        storage = str(information["storage_identifier"])
    except (InputError, KeyError, TypeError) as error:
        if not metadata.exists() and not any(metadata.parent.glob("*.mcap")):
            what = "is no bag: neither metadata.yaml nor an .mcap file is in it"
            raise InputError(str(metadata.parent), what, "name a bag's folder or an .mcap file") from error
        if not metadata.exists():
            raise InputError(
                str(metadata), "is missing", "the recording was cut short: 'roadmend bag recover' it, or take another"
            ) from error
        mend = "'roadmend bag recover' the bag, or take another"
        raise InputError(str(metadata), "does not describe a bag", mend) from error
    for name in names:
        # rosbag2 keeps a bag's files in its folder; a name that leads elsewhere would have any file read as a bag.
        if Path(name).is_absolute() or ".." in Path(name).parts or "\0" in name:
            raise InputError(str(metadata), f"names {name!r}, which lies outside the bag", "take another bag")
    return information | {"storage_identifier": storage, "relative_file_paths": names}


def refuse_foreign(file: Path) -> None:
    """Refuse files that are known to be bags of another kind.

    Raises:
        InputError: the file is one, or cannot be read.
    """
    try:
        with open_regular(file) as stream:
            begin = stream.read(16)
    except OSError as error:
        raise InputError(str(file), f"cannot be read ({error.strerror})", "name a file that can be read") from error
    if begin.startswith(b"#ROSBAG"):
        raise InputError(str(file), "is a bag of ROS 1", "turn it into one of ROS 2 with 'rosbags-convert'")
    if begin.startswith(b"SQLite format 3"):
        raise InputError(
            str(file), "is the database of a sqlite3 bag", "turn its folder into mcap with 'roadmend bag convert'"
        )


class _Dumper(yaml.SafeDumper):
    """Writes each part in full: equal parts would else become YAML anchors, which rosbag2 does not write."""

    def ignore_aliases(self, data: Any) -> bool:  # noqa: ARG002 -- the signature is PyYAML's
        return True
