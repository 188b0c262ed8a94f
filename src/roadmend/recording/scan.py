"""Reading an MCAP file from front to back as far as it goes: cut, damaged, without index, and in little memory."""

import math
import re
import struct
from collections import Counter
from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Attachment as AttachmentRecord
from mcap.records import Channel, Metadata, Schema
from mcap.writer import MCAP0_MAGIC as MAGIC

from roadmend.core.bounded_file import open_regular
from roadmend.core.bounds import BAG, Allowance
from roadmend.core.errors import InputError
from roadmend.recording import layout, qos
from roadmend.recording.chunk import RECORD_HEAD, RECORD_LIMIT, ChunkReader, DamagedError, exactly
from roadmend.recording.definitions import ENCODINGS, Definition, same_layout
from roadmend.recording.enclosure import Attachment
from roadmend.recording.mcap_file import McapFile, is_altered
from roadmend.recording.qos import Qos
from roadmend.recording.reader import CORRUPT
from roadmend.recording.scan_report import ScanReport

_MESSAGE = struct.Struct("<HIQQ")  # channel, sequence, log time, publish time
# Looked for ahead: a byte that only looks like a beginning must not hide the true one a little behind it.
_CHUNK_SIGN = re.compile(rb"(?=\x06.{36}(?:\x00{4}|\x04\x00{3}zstd|\x03\x00{3}lz4))", re.DOTALL)
_SEARCH_PIECE = 1 << 20  # [bytes]
_SIGN_LENGTH = 45  # [bytes] the longest that the above looks at
_FIXED = {int(Opcode.FOOTER): 20, int(Opcode.DATA_END): 4}  # lengths [bytes]


@dataclass(frozen=True, slots=True)
class ScannedTopic:
    """A topic as a file describes it."""

    name: str
    definition: Definition
    offers: tuple[Qos, ...]
    problem: str  # why a bag of ROS 2 cannot hold it; empty if it can


@dataclass(slots=True)
class ScannedMessage:
    """One whole message."""

    topic: ScannedTopic
    time_ns: int  # log time
    publish_ns: int
    sequence: int
    data: bytes


@dataclass(frozen=True, slots=True)
class NamedTexts:
    """One metadata record."""

    name: str
    values: dict[str, str]


Item = ScannedMessage | NamedTexts | Attachment


class Scan:
    """Goes through one file once. Iterate over it; ``report`` grows meanwhile.

    Args:
        path: the file.
        advance: called with the number of bytes that were passed.

    Raises:
        InputError: the file cannot be read, is empty, or is no MCAP file at all.
    """

    def __init__(self, path: Path, advance: Callable[[int], None] = lambda _count: None) -> None:
        self.path = path
        self.report = ScanReport()
        self._advance = advance
        self._schemas: dict[int, Schema] = {}
        self._topics: dict[int, ScannedTopic] = {}
        layout.refuse_foreign(path)
        self._size = path.stat().st_size
        self._allowance = Allowance(str(path), self._size, BAG)
        if not self._size:
            raise InputError(str(path), "is empty", "there is nothing to recover; take another bag")

    def __iter__(self) -> Iterator[Item]:
        try:
            with open_regular(self.path) as stream:
                self._read_summary(stream)
                stream.seek(0)
                begin = 0
                if stream.read(len(MAGIC)) == MAGIC:
                    begin = len(MAGIC)
                elif (found := self._search(stream, 0, RECORD_LIMIT)) is not None:
                    begin = found
                    self.report.add(f"the first {begin} bytes are damaged")
                else:
                    raise InputError(str(self.path), "is no MCAP file", "take another file")
                yield from self._records(stream, begin)
        except OSError as error:
            raise InputError(str(self.path), f"cannot be read ({error.strerror})", "copy it to a sound disk") from error

    def _read_summary(self, stream: BinaryIO) -> None:
        """Learn from the index, if there is one, what a damaged file should hold."""
        try:
            file = McapFile(stream, str(self.path), is_lenient=True)
            summary = file.summary
            if summary is None:
                return
            if file.is_altered:
                self.report.add("the index: its checksum is wrong, it may be altered")
            for schema in summary.schemas.values():
                self._schemas[schema.id] = schema
            for channel in summary.channels.values():
                self._add_channel(channel)
            if summary.statistics is not None and not file.is_altered:
                counts = summary.statistics.channel_message_counts
                expected: Counter[str] = Counter()
                for channel, count in counts.items():
                    expected[summary.channels[channel].topic] += count
                self.report.expected = expected
        except (*CORRUPT, InputError):
            self.report.expected = None

    def _records(self, stream: BinaryIO, begin: int) -> Iterator[Item]:
        """The file's records from ``begin`` on, over damaged places."""
        place: int | None = begin
        told = 0
        while place is not None:
            self._advance(place - told)
            told = place
            stream.seek(place)
            head = stream.read(RECORD_HEAD.size)
            if len(head) < RECORD_HEAD.size:
                break
            opcode, length = RECORD_HEAD.unpack(head)
            after = place + RECORD_HEAD.size + length
            if opcode == Opcode.CHUNK:
                place = yield from self._chunk(stream, place, after)
                continue
            if not self._is_plausible(opcode, length, after):
                place = self._over(stream, place)
                continue
            if opcode == Opcode.FOOTER:
                stream.seek(after)
                self.report.has_end = stream.read(len(MAGIC)) == MAGIC
                break
            if opcode == Opcode.MESSAGE or opcode in _READ:
                item = self._record(stream, opcode, place, length)
                if item is not None:
                    yield item
            place = after
            if opcode == Opcode.DATA_END:
                place = self._footer(stream) or place
        self._advance(self._size - told)

    def _is_plausible(self, opcode: int, length: int, after: int) -> bool:
        fixed = _FIXED.get(opcode, length)
        return (
            (Opcode.HEADER <= opcode <= Opcode.DATA_END or opcode >= 0x80) and length == fixed and after <= self._size
        )

    def _record(self, stream: BinaryIO, opcode: int, place: int, length: int) -> Item | None:
        if length > RECORD_LIMIT:
            self.report.add(f"at byte {place}: a record of {length >> 20} MB is passed over")
            return None
        try:
            self._allowance.take(length)
            return self._take(opcode, exactly(stream.read, length))
        except DamagedError as error:
            self.report.add(f"at byte {place}: {error}")
            return None

    def _chunk(self, stream: BinaryIO, place: int, after: int) -> Generator[Item, None, int | None]:
        """The chunk's messages; returns where to go on."""
        kept = 0
        chunk = None
        try:
            chunk = ChunkReader(stream, self._size)
            for opcode, content in chunk.records(self._allowance):
                item = self._take(opcode, content)
                if item is not None:
                    kept += 1
                    yield item
        except DamagedError as error:
            if chunk is None:
                return self._over(stream, place)
            what = "it was cut" if chunk.is_cut else str(error)
            self.report.add(f"chunk at byte {place}: {what}; {kept} messages of it are kept")
            stream.seek(min(after, self._size))
            head = stream.read(RECORD_HEAD.size)
            if after != chunk.end or len(head) < RECORD_HEAD.size or not self._follows(after, head):
                return self._search(stream, chunk.begin)
        else:
            if after != chunk.end:
                self.report.add(f"chunk at byte {place}: its length is damaged; {kept} messages of it are kept")
                return self._search(stream, chunk.begin)
        return after

    def _follows(self, place: int, head: bytes) -> bool:
        opcode, length = RECORD_HEAD.unpack(head)
        return self._is_plausible(opcode, length, place + RECORD_HEAD.size + length)

    def _take(self, opcode: int, content: bytes) -> Item | None:
        """What one record holds.

        Raises:
            DamagedError: it is not what it claims to be.
        """
        if opcode == Opcode.MESSAGE:
            return self._message(content)
        if opcode not in _READ:
            return None
        try:
            record: Any = _READ[opcode](ReadDataStream(BytesIO(content)))
        except CORRUPT as error:
            raise DamagedError("a record is damaged") from error
        if opcode == Opcode.SCHEMA:
            self._schemas[record.id] = record
            return None
        if opcode == Opcode.CHANNEL:
            self._add_channel(record)
            return None
        if opcode == Opcode.METADATA:
            return NamedTexts(record.name, record.metadata)
        if is_altered(content):
            self.report.add(f"attachment {record.name}: its checksum is wrong, it may be altered")
        return Attachment(record.name, record.media_type, record.data)

    def _message(self, content: bytes) -> ScannedMessage | None:
        if len(content) < _MESSAGE.size:
            raise DamagedError("a message is too short")
        channel, sequence, time_ns, publish_ns = _MESSAGE.unpack_from(content)
        topic = self._topics.get(channel)
        if topic is None or max(time_ns, publish_ns) >= layout.TIME_LIMIT:
            self.report.nameless += 1
            return None
        self.report.messages[topic.name] += 1
        if topic.problem:
            self.report.left_out[topic.name] = topic.problem
            return None
        return ScannedMessage(topic, time_ns, publish_ns, sequence, content[_MESSAGE.size :])

    def _add_channel(self, channel: Channel) -> None:
        schema = self._schemas.get(channel.schema_id)
        problem = (
            "" if channel.message_encoding == "cdr" else f"its messages are {channel.message_encoding or 'unnamed'}"
        )
        if schema is None:
            problem = problem or "its definition is lost"
        elif schema.encoding not in ENCODINGS:
            problem = problem or f"its definition is {schema.encoding or 'unnamed'}"
        type_hash = channel.metadata.get("topic_type_hash", "")
        try:
            text = "" if schema is None else schema.data.decode()
            offers = qos.load(channel.metadata.get("offered_qos_profiles", ""))
        except (*CORRUPT, InputError):
            problem, text, offers = problem or "its definition or quality of service is damaged", "", ()
        name, encoding = ("", "") if schema is None else (schema.name, schema.encoding)
        definition = Definition(name, text, type_hash, encoding)
        if schema is not None and not problem:
            problem = self._clash(channel.topic, definition)
        self._topics[channel.id] = ScannedTopic(channel.topic, definition, offers, problem)

    def _clash(self, topic: str, definition: Definition) -> str:
        """Why a channel cannot stand beside those before it: a bag has one type a topic, and one definition a type."""
        for one in self._topics.values():
            if one.problem:
                continue
            if one.name == topic and one.definition.type_name != definition.type_name:
                return f"some are {definition.type_name}, those before them {one.definition.type_name}"
            if not same_layout(one.definition, definition):
                return f"their {definition.type_name} is another than that of {one.name}"
        return ""

    def _footer(self, stream: BinaryIO) -> int | None:
        """Where the footer stands if the file ends with one: what lies before it is the index, which was read."""
        place = self._size - len(MAGIC) - RECORD_HEAD.size - _FIXED[Opcode.FOOTER]
        stream.seek(max(place, 0))
        return place if stream.read(1) == bytes([Opcode.FOOTER]) else None

    def _over(self, stream: BinaryIO, place: int) -> int | None:
        """The next chunk behind a damaged place."""
        found = self._search(stream, place + 1)
        if found is None:
            self.report.add(f"the last {self._size - place} bytes make no whole record")
        else:
            self.report.add(f"{found - place} bytes from byte {place} on are damaged")
        return found

    def _search(self, stream: BinaryIO, place: int, end: float = math.inf) -> int | None:
        """Where the next chunk begins, from ``place`` on, and before ``end`` or little behind it."""
        stream.seek(place)
        rest = b""
        while place < end and (piece := stream.read(_SEARCH_PIECE)):
            block = rest + piece
            for match in _CHUNK_SIGN.finditer(block):
                at = place - len(rest) + match.start()
                if self._is_chunk(stream, at):
                    return at
            place += len(piece)
            rest = block[-_SIGN_LENGTH:]
            stream.seek(place)
        return None

    def _is_chunk(self, stream: BinaryIO, place: int) -> bool:
        """Whether the lengths that a chunk gives twice agree."""
        stream.seek(place)
        _, length = RECORD_HEAD.unpack(stream.read(RECORD_HEAD.size))
        try:
            chunk = ChunkReader(stream, self._size)
        except DamagedError:
            return False
        return bool(chunk.end == place + RECORD_HEAD.size + length)


_READ: dict[int, Any] = {
    Opcode.SCHEMA: Schema.read,
    Opcode.CHANNEL: Channel.read,
    Opcode.METADATA: Metadata.read,
    Opcode.ATTACHMENT: AttachmentRecord.read,
}
