"""The records of one MCAP chunk, as many as can still be read, without ever holding the whole chunk in memory."""

import io
import struct
import zlib
from collections.abc import Callable, Iterator
from typing import BinaryIO, cast

import lz4.frame
import zstandard

from roadmend.core.bounds import BAG, Allowance

RECORD_LIMIT = BAG.line  # [bytes] a longer record is taken for damage
RECORD_HEAD = struct.Struct("<BQ")  # opcode, length
_HEAD = struct.Struct("<QQQI")  # start, end, size and checksum before compression
_LENGTH = struct.Struct("<Q")
_PIECE = 1 << 16  # [bytes] read at once
_EFFORT = 200  # [bytes] that a record counts for besides its own: it takes time however short it is


class DamagedError(Exception):
    """The bytes cannot be what they claim to be."""


class ChunkReader:
    """Reads one chunk from where the stream stands: behind the opcode and the length of its record.

    Args:
        stream: the file.
        size: of the file [bytes].

    Raises:
        DamagedError: the chunk's own head makes no sense.
    """

    def __init__(self, stream: BinaryIO, size: int) -> None:
        head = exactly(stream.read, _HEAD.size)
        start, end, self.size, self.checksum = _HEAD.unpack(head)
        (named,) = struct.unpack("<I", exactly(stream.read, 4))
        name = exactly(stream.read, named) if named <= 4 else b"?"
        (length,) = _LENGTH.unpack(exactly(stream.read, _LENGTH.size))
        if start > end or name not in _OPENERS:
            raise DamagedError("its head is damaged")
        self.begin = stream.tell()  # of the data
        self.end = self.begin + length
        self.is_cut = self.end > size
        self._read = _OPENERS[name](_Window(stream, min(length, size - self.begin)))

    def records(self, allowance: Allowance) -> Iterator[tuple[int, bytes]]:
        """Opcode and content of each record.

        Args:
            allowance: of the file. What a chunk says of its size, and what its compressor says, may both be lies; so
                each record is asked room for before it is unpacked.

        Raises:
            DamagedError: what follows cannot be read, or the whole does not match its checksum.
            InputError: more comes out of the file than it may hold.
        """
        count = checksum = 0
        while count < self.size:
            head = exactly(self._read, RECORD_HEAD.size)
            opcode, length = RECORD_HEAD.unpack(head)
            if length > min(self.size - count, RECORD_LIMIT):
                raise DamagedError(f"a record of it claims {length} bytes")
            allowance.take(RECORD_HEAD.size + length + _EFFORT)
            content = exactly(self._read, length)
            checksum = zlib.crc32(content, zlib.crc32(head, checksum))
            count += len(head) + length
            yield opcode, content
        if self.checksum not in {0, checksum}:
            raise DamagedError("its checksum is wrong: what it holds may be altered")


def exactly(read: Callable[[int], bytes], count: int) -> bytes:
    """Read so many bytes.

    Raises:
        DamagedError: there are fewer.
    """
    try:
        data = read(count)
        while len(data) < count:
            more = read(count - len(data))
            if not more:
                raise DamagedError("it ends too early")
            data += more
    except (zstandard.ZstdError, RuntimeError, EOFError) as error:  # lz4 raises RuntimeError
        raise DamagedError(f"its compressed data are damaged ({error})") from error
    return data


class _Window(io.RawIOBase):
    """The next bytes of a stream and no more."""

    def __init__(self, stream: BinaryIO, length: int) -> None:
        self._stream = stream
        self._left = length

    def read(self, size: int = -1) -> bytes:
        data = self._stream.read(self._left if size < 0 else min(size, self._left))
        self._left -= len(data)
        return data


def _plain(window: _Window) -> Callable[[int], bytes]:
    return window.read


def _zstd(window: _Window) -> Callable[[int], bytes]:
    source = cast("BinaryIO", window)  # all that is asked of it is to read
    return zstandard.ZstdDecompressor(max_window_size=RECORD_LIMIT).stream_reader(source, _PIECE).read


def _lz4(window: _Window) -> Callable[[int], bytes]:
    decompressor = lz4.frame.LZ4FrameDecompressor()

    def read(count: int) -> bytes:
        while not decompressor.eof:
            piece = window.read(_PIECE) if decompressor.needs_input else b""
            data: bytes = decompressor.decompress(piece, count)
            if data or not piece:  # without new input and without output it would stay so for ever
                return data
        return b""

    return read


_OPENERS: dict[bytes, Callable[[_Window], Callable[[int], bytes]]] = {b"": _plain, b"zstd": _zstd, b"lz4": _lz4}
