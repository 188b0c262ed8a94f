"""The folder that makes an MCAP file a rosbag2 bag: NAME/NAME_0.mcap and NAME/metadata.yaml (version 9)."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from roadmend.core.errors import InputError
from roadmend.recording.qos import Qos

METADATA_FILE = "metadata.yaml"
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


def bag_information(file: FileSummary, topics: list[TopicSummary]) -> dict[str, Any]:
    """The bag as rosbag2 jazzy describes it, key by key and in its order."""
    span = file.span
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
        "relative_file_paths": [file.name],
        "files": [{"path": file.name, **file.span}],
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
        path: a bag's folder, or an MCAP file by itself.

    Raises:
        InputError: nothing is there, or the metadata are missing or unusable.
    """
    if path.is_file():
        return [path]
    if not path.is_dir():
        raise InputError(str(path), "there is no such bag", "name a bag's folder or an .mcap file")
    metadata = path / METADATA_FILE
    try:
        information = yaml.safe_load(metadata.read_text("utf-8"))[_ROOT]
        identifier = information["storage_identifier"]
        names = [str(name) for name in information["relative_file_paths"]]
    except FileNotFoundError as error:
        raise InputError(
            str(metadata), "is missing", "the recording was cut short: recover it, or take another"
        ) from error
    except (OSError, UnicodeDecodeError, yaml.YAMLError, KeyError, TypeError) as error:
        raise InputError(str(metadata), "does not describe a bag", "recover the bag, or take another") from error
    if identifier != "mcap":
        raise InputError(str(metadata), f"the bag's storage is {identifier!r}", "convert the bag to mcap")
    return [path / name for name in names]


class _Dumper(yaml.SafeDumper):
    """Writes each part in full: equal parts would else become YAML anchors, which rosbag2 does not write."""

    def ignore_aliases(self, data: Any) -> bool:  # noqa: ARG002 -- the signature is PyYAML's
        return True
