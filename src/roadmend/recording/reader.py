"""Reading bags: messages in the order of their time, as bytes or decoded, and what else the bag carries."""

import contextlib
import heapq
import struct
from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import yaml
from mcap.exceptions import McapError
from mcap.summary import Summary
from zstandard import ZstdError

from roadmend.core.bounded_file import open_regular
from roadmend.core.bounds import BAG
from roadmend.core.errors import InputError
from roadmend.recording import layout, qos
from roadmend.recording.chunk import DamagedError
from roadmend.recording.codec import Codec
from roadmend.recording.definitions import ENCODINGS, Definition, same_layout
from roadmend.recording.enclosure import Attachment
from roadmend.recording.layout import FileSummary, TopicSummary
from roadmend.recording.mcap_file import McapFile
from roadmend.recording.repeats import Repeats

_RECOVER = "'roadmend bag recover' it, or take another"
# Whatever the parsers of a corrupt file stumble over.
CORRUPT = (
    DamagedError,
    McapError,
    ZstdError,
    struct.error,
    yaml.YAMLError,
    OSError,
    EOFError,
    ValueError,
    LookupError,
    TypeError,
    AttributeError,
    StopIteration,
    RuntimeError,
    MemoryError,
    OverflowError,
)


@dataclass(frozen=True, slots=True)
class Record:
    """One message as it lies in the bag."""

    topic: str
    type_name: str  # package/msg/Name
    time_ns: int  # log time, which is simulation time [ns]
    data: bytes  # CDR
    publish_ns: int  # when it was sent [ns]
    sequence: int  # its number


@dataclass(frozen=True, slots=True)
class DecodedMessage:
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
        self._paths = layout.files_of(path)
        self._repeated: list[dict[str, Repeats]] = []  # for each file, by topic, which messages repeat earlier ones
        self._codec = Codec()
        for file in self._paths:
            with _reading(file) as reader:
                self._read_summary(file, reader)

    @cached_property
    def attachments(self) -> dict[str, Attachment]:
        """Files that the bag carries, by name; of one name, the last."""
        found: dict[str, Attachment] = {}
        for path in self._paths:
            with _reading(path) as reader:
                for one in reader.attachments():
                    found[one.name] = Attachment(one.name, one.media_type, one.data)
        return found

    @property
    def count(self) -> int:
        """Number of messages, without those that a further file repeats."""
        return sum(topic.count for topic in self.topics.values())

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
        waiting = sorted((file.start_ns, place) for place, file in enumerate(self.files) if file.count)
        waiting.reverse()
        # Files overlap where a message came late: each is opened when its first message is due.
        due: list[tuple[int, int, Record, Iterator[Record]]] = []
        while due or waiting:
            while waiting and (not due or waiting[-1][0] <= due[0][0]):
                _, place = waiting.pop()
                _push(due, place, self._records_of(place, topics))
            if due:
                _, place, record, others = heapq.heappop(due)
                yield record
                _push(due, place, others)

    def _records_of(self, place: int, topics: Collection[str] | None) -> Iterator[Record]:
        takers = {topic: repeats.taker() for topic, repeats in self._repeated[place].items()}
        with _reading(self._paths[place]) as reader:
            for schema, channel, message in reader.messages(topics):
                is_repeat = takers.get(channel.topic)
                if is_repeat is None or not is_repeat(message.log_time, message.sequence):
                    yield Record(
                        channel.topic,
                        schema.name,
                        message.log_time,
                        message.data,
                        message.publish_time,
                        message.sequence,
                    )

    def messages(self, topics: Collection[str] | None = None) -> Iterator[DecodedMessage]:
        """The messages decoded, in the order of ``records``."""
        for record in self.records(topics):
            yield DecodedMessage(record.topic, record.type_name, record.time_ns, self.decode(record))

    def decode(self, record: Record) -> Any:
        """The fields of a message, by the definition that the bag carries."""
        try:
            return self._codec.decode(self.definitions[record.type_name], record.data)
        except ValueError as error:
            what = f"a message on {record.topic} is not a {record.type_name}"
            raise InputError(str(self.path), what, "take another bag") from error

    def _read_summary(self, path: Path, reader: McapFile) -> None:
        summary = reader.summary
        if summary is None or summary.statistics is None:
            raise InputError(str(path), "has no index", _RECOVER)
        _refuse_unreadable(path, summary)
        if summary.statistics.message_end_time >= layout.TIME_LIMIT:
            raise InputError(str(path), "has messages later than a bag of ROS 2 can say", _RECOVER)
        for metadata in reader.metadata():
            self.metadata.setdefault(metadata.name, {}).update(metadata.metadata)
        repeated = self.metadata.pop(layout.REPEATED, {})
        # A file that is read by itself keeps what it repeats: it is not in any other.
        self._repeated.append({topic: Repeats.parse(text) for topic, text in repeated.items() if self.files})
        counts = summary.statistics.channel_message_counts
        for channel in summary.channels.values():
            schema = summary.schemas[channel.schema_id]
            type_hash = channel.metadata.get("topic_type_hash", "")
            known = self.topics.get(channel.topic)
            if known is None:
                offers = qos.load(channel.metadata.get("offered_qos_profiles", ""))
                known = TopicSummary(channel.topic, schema.name, type_hash, offers, 0)
                definition = Definition(schema.name, schema.data.decode(), type_hash, schema.encoding)
                if not same_layout(self.definitions.setdefault(schema.name, definition), definition):
                    what = f"has two definitions of {schema.name}; that of {channel.topic} is another"
                    raise InputError(str(path), what, "keep bags of different versions apart")
            elif known.type_name != schema.name:
                what = f"{channel.topic} has two types, {known.type_name} and {schema.name}"
                raise InputError(str(path), what, "take another bag")
            self.topics[channel.topic] = replace(known, count=known.count + counts.get(channel.id, 0))
        for topic, repeats in self._repeated[-1].items():
            if (known := self.topics.get(topic)) is not None:
                self.topics[topic] = replace(known, count=max(0, known.count - len(repeats)))
        statistics = summary.statistics
        self.files.append(
            FileSummary(path.name, statistics.message_count, statistics.message_start_time, statistics.message_end_time)
        )


def _push(due: list[tuple[int, int, Record, Iterator[Record]]], place: int, records: Iterator[Record]) -> None:
    record = next(records, None)
    if record is not None:
        heapq.heappush(due, (record.time_ns, place, record, records))


def _refuse_unreadable(path: Path, summary: Summary) -> None:
    """Refuse what is no bag of ROS 2, and what would have to be read at once and does not fit."""
    for channel in summary.channels.values():
        schema = summary.schemas.get(channel.schema_id)
        encoding = schema.encoding if schema is not None else "no schema"
        if channel.message_encoding != "cdr" or encoding not in ENCODINGS:
            what = f"{channel.topic} holds {channel.message_encoding or 'unnamed'} messages with {encoding}"
            raise InputError(str(path), what, "take a bag of ROS 2 (cdr with ros2msg or ros2idl)")
    pieces = [chunk.uncompressed_size for chunk in summary.chunk_indexes] or [path.stat().st_size]
    if max(pieces) > BAG.line:
        what = f"{max(pieces) >> 20} MB of it would have to be read at once"
        raise InputError(str(path), what, "rewrite it in smaller chunks with 'roadmend bag recover'")


@contextlib.contextmanager
def _reading(path: Path) -> Iterator[McapFile]:
    """A reader of one MCAP file; what goes wrong inside the context becomes one line for people."""
    try:
        with open_regular(path) as stream:
            yield McapFile(stream, str(path))
    except FileNotFoundError as error:
        raise InputError(str(path), "is missing", "restore the file, or take another bag") from error
    except CORRUPT as error:
        what = str(error) or type(error).__name__
        raise InputError(str(path), f"was cut short or is corrupt ({what})", _RECOVER) from error
