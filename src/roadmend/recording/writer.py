"""Writing bags: rosbag2 layout, MCAP, one episode a bag."""

import contextlib
import math
import time
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from types import TracebackType
from typing import Self

from mcap.writer import CompressionType, Writer

from roadmend.core.errors import InputError
from roadmend.recording import layout, qos
from roadmend.recording.definitions import Definition, find
from roadmend.recording.errors import RecordingError
from roadmend.recording.layout import FileSummary, TopicSummary
from roadmend.recording.qos import Qos


class Compression(StrEnum):
    """How chunks are compressed."""

    ZSTD = "zstd"
    LZ4 = "lz4"
    NONE = "none"


_MCAP_COMPRESSION = {
    Compression.ZSTD: CompressionType.ZSTD,
    Compression.LZ4: CompressionType.LZ4,
    Compression.NONE: CompressionType.NONE,
}


@dataclass(frozen=True, slots=True)
class BagOptions:
    """How a bag is written."""

    compression: Compression = Compression.ZSTD
    chunk_size: int = 1 << 20  # [bytes] before compression, at which a chunk is written
    flush_interval: float = 0.25  # [s] of wall time after which a chunk is written even if it is small


@dataclass(slots=True)
class _Topic:
    """A topic while it is being written; its channel is registered with its first message."""

    definition: Definition
    offers: tuple[Qos, ...]
    channel: int = 0
    count: int = 0


class BagWriter:
    """Writes one bag.

    What was written more than ``flush_interval`` ago survives SIGKILL. The file is complete, with indexes,
    statistics and ``metadata.yaml``, once ``close`` has returned. A bag that failed stays as it is, without
    ``metadata.yaml``, and takes nothing more.

    Args:
        folder: the bag's folder, which must not exist yet; its name is the bag's name.
        options: how to write.

    Raises:
        InputError: the folder exists already or cannot be made.
    """

    def __init__(self, folder: Path, options: BagOptions = BagOptions()) -> None:
        self.folder = folder
        self.file = folder / f"{folder.name}_0.mcap"
        self.bytes = 0  # of message data, before compression
        self.count = 0  # messages
        try:
            folder.mkdir(parents=True)
            self._stream = self.file.open("xb")
        except FileExistsError as error:
            raise InputError(str(folder), "exists already", "choose another name or remove it") from error
        except OSError as error:
            raise InputError(str(folder), f"cannot be written ({error.strerror})", "choose another folder") from error
        self._writer = Writer(
            self._stream, chunk_size=options.chunk_size, compression=_MCAP_COMPRESSION[options.compression]
        )
        self._topics: dict[str, _Topic] = {}
        self._schemas: dict[str, int] = {}
        self._start_ns = math.inf
        self._end_ns = 0
        self._flush_interval = options.flush_interval
        self._flush_due = time.monotonic() + options.flush_interval
        self._open = True
        with self._failing():
            self._writer.start("ros2")

    @property
    def is_open(self) -> bool:
        """Whether more can be written: false after ``close`` and after a failure."""
        return self._open

    def add_topic(
        self, name: str, type_name: str, offers: Iterable[Qos] = (), definition: Definition | None = None
    ) -> None:
        """Announce a topic before its first message.

        Announcing it again before the first message replaces the offers. Later ones are left out: the channel in the
        file cannot be changed any more, and rosbags passes over a topic of which metadata.yaml says anything else.

        Args:
            name: the topic, with its namespace.
            type_name: package/msg/Name.
            offers: what the topic's publishers offer.
            definition: the type's definition; looked up among the installed packages if it is missing.

        Raises:
            InputError: no definition of the type is installed, or the topic was announced with another type.
        """
        found = definition or find(type_name)
        known = self._topics.get(name)
        if known is None:
            self._topics[name] = _Topic(found, tuple(offers))
        elif known.definition.type_name != found.type_name:
            raise InputError(name, f"has two types, {known.definition.type_name} and {type_name}", "record one of them")
        elif not known.channel:
            known.offers = tuple(offers)

    def write(self, topic: str, time_ns: int, data: bytes) -> None:
        """Write one message.

        Args:
            topic: a topic that was announced.
            time_ns: simulation time [ns], which becomes log time and publish time.
            data: the message, serialized as CDR.

        Raises:
            KeyError: the topic was not announced.
            ValueError: the time is negative.
            RecordingError: the file cannot be written, or the bag is closed.
        """
        entry = self._topics[topic]
        if not self._open:
            raise RecordingError(str(self.file), "the bag is closed")
        if time_ns < self._start_ns:
            if time_ns < 0:
                raise ValueError(f"{topic}: time {time_ns} ns is negative")
            self._start_ns = time_ns
        self._end_ns = max(self._end_ns, time_ns)
        try:
            if not entry.channel:
                entry.channel = self._register(topic, entry)
            entry.count += 1
            self._writer.add_message(entry.channel, time_ns, data, time_ns, entry.count & 0xFFFFFFFF)
        except OSError as error:
            raise self._failure(error) from error
        self.count += 1
        self.bytes += len(data)
        if time.monotonic() >= self._flush_due:
            self.flush()

    def add_metadata(self, name: str, values: Mapping[str, str]) -> None:
        """Write a record of named texts. Records of the same name add up, later values win.

        Raises:
            RecordingError: the file cannot be written, or the bag is closed.
        """
        with self._failing():
            self._writer.add_metadata(name, dict(values))

    def add_attachment(self, name: str, media_type: str, data: bytes) -> None:
        """Write a file into the bag.

        Raises:
            RecordingError: the file cannot be written, or the bag is closed.
        """
        with self._failing():
            self._writer.add_attachment(0, self._end_ns, name, media_type, data)

    def flush(self) -> None:
        """Hand everything written so far to the operating system.

        Raises:
            RecordingError: the file cannot be written, or the bag is closed.
        """
        with self._failing():
            self._writer.flush()
        self._flush_due = time.monotonic() + self._flush_interval

    def flush_if_due(self) -> None:
        """Flush if the last time is long enough ago; for a timer, while no messages come.

        Raises:
            RecordingError: the file cannot be written, or the bag is closed.
        """
        if time.monotonic() >= self._flush_due:
            self.flush()

    def close(self) -> None:
        """Complete the bag. Does nothing if that has happened already or the bag has failed.

        Raises:
            RecordingError: the file cannot be written.
        """
        if not self._open:
            return
        information = layout.bag_information(
            FileSummary(self.file.name, self.count, int(self._start_ns) if self.count else 0, self._end_ns),
            [
                TopicSummary(name, topic.definition.type_name, topic.definition.type_hash, topic.offers, topic.count)
                for name, topic in self._topics.items()
            ],
        )
        self.flush()
        self.add_metadata("rosbag2", {"serialized_metadata": layout.as_text(information)})
        with self._failing():
            self._writer.finish()
            self._stream.close()
            layout.write_metadata(self.folder, information)
        self._open = False

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _register(self, name: str, topic: _Topic) -> int:
        definition = topic.definition
        schema = self._schemas.get(definition.type_name)
        if schema is None:
            schema = self._writer.register_schema(definition.type_name, "ros2msg", definition.text.encode())
            self._schemas[definition.type_name] = schema
        details = {"offered_qos_profiles": qos.dump(topic.offers), "topic_type_hash": definition.type_hash}
        return int(self._writer.register_channel(name, "cdr", schema, details))

    @contextlib.contextmanager
    def _failing(self) -> Iterator[None]:
        """Refuse a closed bag; close the bag and raise a typed error where the system refuses to write."""
        if not self._open:
            raise RecordingError(str(self.file), "the bag is closed")
        try:
            yield
        except OSError as error:
            raise self._failure(error) from error

    def _failure(self, error: OSError) -> RecordingError:
        self._open = False
        with contextlib.suppress(OSError):  # closing tries to write once more what is still in the buffer
            self._stream.close()
        return RecordingError(str(self.file), f"cannot be written ({error.strerror})")
