"""One MCAP file of a bag while it is being written."""

import contextlib
import math
from collections.abc import Mapping
from enum import StrEnum
from pathlib import Path

from mcap.writer import CompressionType, Writer

from roadmend.recording import qos
from roadmend.recording.definitions import Definition
from roadmend.recording.enclosure import Attachment
from roadmend.recording.layout import FileSummary
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


class BagFile:
    """Writes one file. What the system refuses comes out of every method as OSError.

    Args:
        path: the file, which must not exist yet.
        compression: of the chunks.
        chunk_size: bytes, before compression, at which a chunk is written.
    """

    def __init__(self, path: Path, compression: Compression, chunk_size: int) -> None:
        self.path = path
        self.count = 0
        self.start_ns = math.inf
        self.end_ns = 0
        self.channels: dict[str, int] = {}
        self._schemas: dict[str, int] = {}
        self._stream = path.open("xb")
        self._writer = Writer(self._stream, chunk_size=chunk_size, compression=_MCAP_COMPRESSION[compression])
        self._writer.start("ros2")

    @property
    def size(self) -> int:
        """Bytes that the file has so far, without the chunk that is being filled."""
        return self._stream.tell()

    @property
    def summary(self) -> FileSummary:
        """What the file holds so far."""
        return FileSummary(self.path.name, self.count, int(self.start_ns) if self.count else 0, self.end_ns)

    def add_channel(self, topic: str, definition: Definition, offers: tuple[Qos, ...]) -> None:
        """Register a topic, with its schema."""
        schema = self._schemas.get(definition.type_name)
        if schema is None:
            schema = self._writer.register_schema(definition.type_name, definition.encoding, definition.text.encode())
            self._schemas[definition.type_name] = schema
        details = {"offered_qos_profiles": qos.dump(offers), "topic_type_hash": definition.type_hash}
        self.channels[topic] = int(self._writer.register_channel(topic, "cdr", schema, details))

    def write(self, topic: str, time_ns: int, data: bytes, publish_ns: int, sequence: int) -> None:
        """Write one message of a registered topic."""
        self.start_ns = min(self.start_ns, time_ns)
        self.end_ns = max(self.end_ns, time_ns)
        self._writer.add_message(self.channels[topic], time_ns, data, publish_ns, sequence & 0xFFFFFFFF)
        self.count += 1

    def add_metadata(self, name: str, values: Mapping[str, str]) -> None:
        """Write a record of named texts."""
        self._writer.add_metadata(name, dict(values))

    def add_attachment(self, attachment: Attachment) -> None:
        """Write a file into this one."""
        self._writer.add_attachment(0, self.end_ns, attachment.name, attachment.media_type, attachment.data)

    def flush(self) -> None:
        """Hand everything written so far to the operating system."""
        self._writer.flush()

    def finish(self) -> None:
        """Write the indexes and close the file."""
        self._writer.finish()
        self._stream.close()

    def abandon(self) -> None:
        """Close the file as it is."""
        with contextlib.suppress(OSError):  # closing tries to write once more what is still in the buffer
            self._stream.close()
