"""One MCAP file, read by its index, in bounded memory whatever it claims.

The records are taken apart by the library mcap. Its own readers unpack a chunk at once and believe what chunk and
compressor say of its size, so that 200 kB can become gigabytes; here every record is asked room for first.
"""

import heapq
import os
import zlib
from collections.abc import Collection, Iterator
from io import BytesIO
from typing import Any, BinaryIO

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    ChunkIndex,
    Footer,
    Message,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
)
from mcap.summary import Summary
from mcap.writer import MCAP0_MAGIC as MAGIC

from roadmend.core.bounds import BAG, Allowance
from roadmend.core.errors import InputError
from roadmend.recording.chunk import RECORD_HEAD, RECORD_LIMIT, ChunkReader, DamagedError, exactly

_FOOTER_SIZE = RECORD_HEAD.size + 20  # [bytes]
_CRC_TO_END = 4 + len(MAGIC)  # [bytes] the checksum of the index, which holds for all from its begin to before this
_PIECE = 1 << 20  # [bytes] read at once
HELD_MAX = 2 * RECORD_LIMIT  # [bytes] of chunks whose times overlap, which are in memory together
_IN_SUMMARY: dict[int, Any] = {
    Opcode.ATTACHMENT_INDEX: AttachmentIndex,
    Opcode.CHANNEL: Channel,
    Opcode.CHUNK_INDEX: ChunkIndex,
    Opcode.METADATA_INDEX: MetadataIndex,
    Opcode.SCHEMA: Schema,
    Opcode.STATISTICS: Statistics,
}

Found = tuple[Schema, Channel, Message]


class McapFile:
    """Reads one file.

    Every method may raise ``DamagedError``, whatever the library's parsers stumble over (``reader.CORRUPT``), or
    ``InputError`` where more comes out of the file than it may hold.

    Args:
        stream: the file.
        where: what to call it.
        is_lenient: whether an index that is not what was written counts, for who looks for what is left.
    """

    def __init__(self, stream: BinaryIO, where: str, *, is_lenient: bool = False) -> None:
        self._stream = stream
        self._where = where
        self._is_lenient = is_lenient
        self.is_altered = False  # whether the index is not what was written
        self._size = os.fstat(stream.fileno()).st_size
        self._allowance = Allowance(where, self._size, BAG)
        stream.seek(0)
        if stream.read(len(MAGIC)) != MAGIC:
            raise DamagedError("it does not begin as an MCAP file does")
        self.summary = self._read_summary()
        """What stands at the end of the file; None where it has no index."""

    def metadata(self) -> Iterator[Metadata]:
        """The records of named texts that the index names."""
        for index in self._indexed.metadata_indexes:
            yield Metadata.read(_parser(self._content(index.offset, Opcode.METADATA)))

    def attachments(self) -> Iterator[Attachment]:
        """The attachments that the index names."""
        for index in self._indexed.attachment_indexes:
            content = self._content(index.offset, Opcode.ATTACHMENT)
            attachment = Attachment.read(_parser(content))
            if is_altered(content):
                raise DamagedError(f"the checksum of its attachment {attachment.name} is wrong")
            yield attachment

    def messages(self, topics: Collection[str] | None = None) -> Iterator[Found]:
        """The messages in the order of their log times; those of one time as they lie in the file.

        Args:
            topics: the topics to read; all if missing.
        """
        summary = self._indexed
        held = 0  # [bytes] of the messages that are due
        due: list[tuple[int, int, int, int, Found]] = []  # what stands before the last makes it unique
        chunks = sorted(summary.chunk_indexes, key=lambda one: (one.message_start_time, one.chunk_start_offset))
        if not chunks:
            yield from sorted(self._unindexed(topics), key=lambda found: found[2].log_time)
            return
        for place, index in enumerate(chunks):
            if topics is not None and index.message_index_offsets:
                names = {summary.channels[channel].topic for channel in index.message_index_offsets}
                if names.isdisjoint(topics):
                    continue
            while due and due[0][0] < index.message_start_time:
                found = heapq.heappop(due)[-1]
                held -= len(found[2].data)
                yield found
            for number, (opcode, content) in enumerate(self._chunk(index.chunk_start_offset)):
                if opcode == Opcode.MESSAGE:
                    found = self._found(content)
                    if topics is None or found[1].topic in topics:
                        held += len(found[2].data)
                        heapq.heappush(due, (found[2].log_time, index.chunk_start_offset, place, number, found))
            if held > HELD_MAX:
                what = f"more than {held >> 20} MB of it overlap in time"
                raise InputError(self._where, what, "rewrite it with 'roadmend bag recover'")
        while due:
            yield heapq.heappop(due)[-1]

    @property
    def _indexed(self) -> Summary:
        if self.summary is None:
            raise DamagedError("it has no index")
        return self.summary

    def _found(self, content: bytes) -> Found:
        message = Message.read(_parser(content), len(content))
        channel = self._indexed.channels[message.channel_id]
        return self._indexed.schemas[channel.schema_id], channel, message

    def _unindexed(self, topics: Collection[str] | None) -> Iterator[Found]:
        """The messages of a file without an index of its chunks, or without chunks."""
        place = len(MAGIC)
        while True:
            opcode, length = self._head(place)
            if opcode == Opcode.CHUNK:
                records = self._chunk(place)
            elif opcode == Opcode.MESSAGE:
                records = [(opcode, self._read(length))]
            elif opcode in {Opcode.DATA_END, Opcode.FOOTER}:
                return
            else:
                records = []
            for kind, content in records:
                if kind == Opcode.MESSAGE and (topics is None or self._found(content)[1].topic in topics):
                    yield self._found(content)
            place += RECORD_HEAD.size + length

    def _chunk(self, place: int) -> list[tuple[int, bytes]]:
        """Opcodes and contents of a chunk's records."""
        opcode, length = self._head(place)
        if opcode != Opcode.CHUNK:
            raise DamagedError(f"there is no chunk at byte {place}")
        chunk = ChunkReader(self._stream, self._size)
        if chunk.size > RECORD_LIMIT or chunk.end != place + RECORD_HEAD.size + length:
            raise DamagedError(f"the chunk at byte {place} claims {chunk.size} bytes in {length}")
        return list(chunk.records(self._allowance))

    def _read_summary(self) -> Summary | None:
        place = self._size - len(MAGIC) - _FOOTER_SIZE
        footer = Footer.read(_parser(self._content(place, Opcode.FOOTER)))
        if exactly(self._stream.read, len(MAGIC)) != MAGIC:
            raise DamagedError("it does not end as an MCAP file does")
        if footer.summary_start == 0:
            return None
        self.is_altered = footer.summary_crc not in {0, self._checksum(footer.summary_start, self._size - _CRC_TO_END)}
        if self.is_altered and not self._is_lenient:
            raise DamagedError("the checksum of its index is wrong")
        summary, end, place = Summary(), place, footer.summary_start
        while place < end:
            opcode, length = self._head(place)
            if opcode in _IN_SUMMARY:
                _add(summary, _IN_SUMMARY[opcode].read(_parser(self._read(length))))
            place += RECORD_HEAD.size + length
        return summary

    def _checksum(self, begin: int, end: int) -> int:
        """Of the bytes from ``begin`` to before ``end``."""
        self._stream.seek(begin)
        checksum = 0
        for place in range(begin, end, _PIECE):
            checksum = zlib.crc32(exactly(self._stream.read, min(_PIECE, end - place)), checksum)
        return checksum

    def _content(self, place: int, opcode: Opcode) -> bytes:
        """What the record at a place holds, which must be of this kind."""
        kind, length = self._head(place)
        if kind != opcode:
            raise DamagedError(f"there is no {opcode.name.lower()} at byte {place}")
        return self._read(length)

    def _head(self, place: int) -> tuple[int, int]:
        """Opcode and length of the record at a place; the stream stands behind them then."""
        if not len(MAGIC) <= place <= self._size - RECORD_HEAD.size:
            raise DamagedError(f"there is no byte {place}")
        self._stream.seek(place)
        opcode, length = RECORD_HEAD.unpack(exactly(self._stream.read, RECORD_HEAD.size))
        if length > self._size - place - RECORD_HEAD.size:
            raise DamagedError(f"the record at byte {place} claims {length} bytes")
        return opcode, length

    def _read(self, length: int) -> bytes:
        if length > RECORD_LIMIT:
            raise DamagedError(f"a record of it claims {length} bytes")
        self._allowance.take(length)
        return exactly(self._stream.read, length)


def is_altered(attachment: bytes) -> bool:
    """Whether an attachment's record is not what was written, by its checksum; 0 is none."""
    return int.from_bytes(attachment[-4:], "little") not in {0, zlib.crc32(attachment[:-4])}


def _parser(content: bytes) -> ReadDataStream:
    return ReadDataStream(BytesIO(content))


def _add(summary: Summary, record: Any) -> None:
    match record:
        case Statistics():
            summary.statistics = record
        case Schema():
            summary.schemas[record.id] = record
        case Channel():
            summary.channels[record.id] = record
        case AttachmentIndex():
            summary.attachment_indexes.append(record)
        case ChunkIndex():
            summary.chunk_indexes.append(record)
        case MetadataIndex():
            summary.metadata_indexes.append(record)
