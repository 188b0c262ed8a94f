"""Reading bags: messages in the order of their time, as bytes or decoded, and what else the bag carries."""

import contextlib
import struct
from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, BinaryIO

import yaml
from mcap.exceptions import McapError
from mcap.reader import SeekingReader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore
from zstandard import ZstdError

from roadmend.core.errors import InputError
from roadmend.recording import layout, qos
from roadmend.recording.definitions import Definition
from roadmend.recording.enclosure import Attachment
from roadmend.recording.layout import FileSummary, TopicSummary

_RECORD_LIMIT = 1 << 30  # [bytes] a longer record means a corrupt file, not a bag of ours
# Whatever the parsers of a corrupt file stumble over.
_CORRUPT = (
    McapError, ZstdError, struct.error, yaml.YAMLError, OSError, EOFError, ValueError, LookupError,
    TypeError, AttributeError, StopIteration, RuntimeError, MemoryError, OverflowError,
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Record:
    """One message as it lies in the bag."""

    topic: str
    type_name: str  # package/msg/Name
    time_ns: int  # log time, which is simulation time [ns]
    data: bytes  # CDR


@dataclass(frozen=True, slots=True)
class Message:
    """One decoded message: ``value`` has the fields of the ROS type, arrays as numpy arrays."""

    topic: str
    type_name: str
    time_ns: int
    value: Any


class BagReader:
    """Reads one bag. Holds no file open between calls.

    Args:
        path: a bag's folder, or an MCAP file by itself.

    Raises:
        InputError: the bag is missing, was cut short or is corrupt. The other methods raise it too, since the
            messages are read only when they are asked for.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.topics: dict[str, TopicSummary] = {}
        self.files: list[FileSummary] = []
        self.definitions: dict[str, Definition] = {}  # by type name
        self.metadata: dict[str, dict[str, str]] = {}  # records of one name joined, later values win
        self.attachments: dict[str, Attachment] = {}  # of one name, the last
        self._paths = layout.files_of(path)
        self._store: Typestore = get_typestore(Stores.EMPTY)
        for file in self._paths:
            with _reading(file) as reader:
                self._read_summary(file, reader)

    @property
    def count(self) -> int:
        """Number of messages."""
        return sum(file.count for file in self.files)

    @property
    def start_ns(self) -> int:
        """Time of the first message [ns]; 0 in an empty bag."""
        return min((file.start_ns for file in self.files if file.count), default=0)

    @property
    def end_ns(self) -> int:
        """Time of the last message [ns]; 0 in an empty bag."""
        return max((file.end_ns for file in self.files if file.count), default=0)

    def records(self, topics: Collection[str] | None = None) -> Iterator[Record]:
        """The messages in the order of their time, those of one time in the order in which they were written.

        Args:
            topics: the topics to read; all if missing.
        """
        for path in self._paths:
            with _reading(path) as reader:
                for schema, channel, message in reader.iter_messages(topics):
                    yield Record(channel.topic, schema.name, message.log_time, message.data)

    def messages(self, topics: Collection[str] | None = None) -> Iterator[Message]:
        """The messages decoded, in the order of ``records``."""
        for record in self.records(topics):
            yield Message(record.topic, record.type_name, record.time_ns, self.decode(record))

    def decode(self, record: Record) -> Any:
        """The fields of a message, by the definition that the bag carries."""
        try:
            if record.type_name not in self._store.fielddefs:
                definition = self.definitions[record.type_name]
                self._store.register(get_types_from_msg(definition.text, definition.type_name))
            return self._store.deserialize_cdr(record.data, record.type_name)
        except Exception as error:  # the parser and the generated decoders raise whatever they stumble over
            raise InputError(
                str(self.path), f"a message on {record.topic} is not a {record.type_name}", "take another bag"
            ) from error

    def _read_summary(self, path: Path, reader: SeekingReader) -> None:
        summary = reader.get_summary()
        if summary is None or summary.statistics is None:
            raise InputError(str(path), "has no index", "recover it, or take another")
        counts = summary.statistics.channel_message_counts
        for channel in summary.channels.values():
            schema = summary.schemas[channel.schema_id]
            type_hash = channel.metadata.get("topic_type_hash", "")
            count = counts.get(channel.id, 0)
            known = self.topics.get(channel.topic)
            if known is None:
                offers = qos.load(channel.metadata.get("offered_qos_profiles", ""))
                self.topics[channel.topic] = TopicSummary(channel.topic, schema.name, type_hash, offers, count)
                self.definitions[schema.name] = Definition(schema.name, schema.data.decode(), type_hash)
            else:
                self.topics[channel.topic] = replace(known, count=known.count + count)
        statistics = summary.statistics
        self.files.append(
            FileSummary(path.name, statistics.message_count, statistics.message_start_time, statistics.message_end_time)
        )
        for metadata in reader.iter_metadata():
            self.metadata.setdefault(metadata.name, {}).update(metadata.metadata)
        for found in reader.iter_attachments():
            self.attachments[found.name] = Attachment(found.name, found.media_type, found.data)


@contextlib.contextmanager
def _reading(path: Path) -> Iterator[SeekingReader]:
    """A reader of one MCAP file; what goes wrong inside the context becomes one line for people."""
    try:
        with path.open("rb") as stream:
            yield _reader(stream)
    except FileNotFoundError as error:
        raise InputError(str(path), "is missing", "restore the file, or take another bag") from error
    except _CORRUPT as error:
        what = str(error) or type(error).__name__
        raise InputError(str(path), f"was cut short or is corrupt ({what})", "recover it, or take another") from error


def _reader(stream: BinaryIO) -> SeekingReader:
    return SeekingReader(stream, validate_crcs=True, record_size_limit=_RECORD_LIMIT)
