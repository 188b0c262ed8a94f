"""Files from outside, opened so that none of them can hang, or fill the memory, before it is looked at."""

import errno
import gzip
import io
import os
import stat
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO, cast

from roadmend.core.bounds import Bounds
from roadmend.core.errors import InputError

UTF8 = "give a readable UTF-8 text file"
_GZIP = b"\x1f\x8b"


def open_regular(path: Path) -> BinaryIO:
    """A file to read; opening it never waits for somebody to write, as opening a FIFO would.

    Raises:
        OSError: it cannot be opened, or is a folder, a device, a FIFO or a socket.
    """
    descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    mode = os.fstat(descriptor).st_mode
    if stat.S_ISREG(mode):
        return os.fdopen(descriptor, "rb")
    os.close(descriptor)
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    raise OSError(errno.EINVAL, "a device, pipe or socket, not a file", str(path))


@contextmanager
def opened(path: Path, mend: str) -> Iterator[BinaryIO]:
    """A file to read; what the system refuses in the context becomes one line.

    Args:
        path: the file.
        mend: what to say where it is missing or cannot be read.

    Raises:
        InputError: it is missing, cannot be read, or is no regular file.
    """
    try:
        try:
            file = open_regular(path)
        except ValueError as error:  # a NUL in its name
            raise InputError(repr(str(path)), f"is no name of a file ({error})", mend) from None
        with file:
            yield file
    except FileNotFoundError:
        raise InputError(str(path), "no such file", mend) from None
    except OSError as error:
        raise InputError(str(path), f"cannot be read ({error.strerror or error})", mend) from None


def read_bytes(path: Path, bounds: Bounds, mend: str) -> bytes:
    """The content of a file.

    Raises:
        InputError: it is missing, cannot be read, is no regular file, or is too large.
    """
    with opened(path, mend) as file:
        bounds.check_size(str(path), os.fstat(file.fileno()).st_size)
        content = file.read(bounds.size + 1)  # a file of /proc tells no size
    bounds.check_size(str(path), len(content))
    return content


def read_text(path: Path, bounds: Bounds, mend: str = UTF8) -> str:
    """The content of a UTF-8 text file, its lines ended by one line feed each.

    Raises:
        InputError: as ``read_bytes``, or it is no UTF-8.
    """
    content = read_bytes(path, bounds, mend)
    try:
        text = content.decode("utf-8")
    except UnicodeDecodeError as error:
        raise InputError(str(path), f"cannot be read ({error})", UTF8) from None
    return text.replace("\r\n", "\n").replace("\r", "\n")


def read_lines(path: Path, bounds: Bounds, mend: str = UTF8) -> Iterator[str]:
    """The lines of a UTF-8 text file, one at a time, each with its end.

    Raises:
        InputError: as ``read_text``, or a line is too long.
    """
    with opened(path, mend) as file:
        bounds.check_size(str(path), os.fstat(file.fileno()).st_size)
        number = 0
        while line := file.readline(bounds.line + 1):
            number += 1
            if len(line) > bounds.line:
                what = f"is longer than {bounds.line / 1e6:.0f} MB"
                raise InputError(f"{path} line {number}", what, "give another file")
            try:
                yield line.decode("utf-8")
            except UnicodeDecodeError as error:
                raise InputError(f"{path} line {number}", f"cannot be read ({error})", UTF8) from None


@contextmanager
def opened_unpacked(path: Path, bounds: Bounds, mend: str) -> Iterator[BinaryIO]:
    """The content of a file to read, unpacked where gzip has packed it; reading stops where it becomes too much.

    Raises:
        InputError: as ``read_bytes``; what is packed is broken; or it unpacks to more than ``bounds.room``.
    """
    with opened(path, mend) as file:
        size = os.fstat(file.fileno()).st_size
        bounds.check_size(str(path), size)
        is_packed = file.read(len(_GZIP)) == _GZIP
        file.seek(0)
        if not is_packed:
            yield file
            return
        try:
            with gzip.open(file) as content:
                yield cast("BinaryIO", _Limited(content, str(path), bounds.room(size)))
        except (EOFError, gzip.BadGzipFile, zlib.error) as error:
            raise InputError(str(path), f"is broken where it is compressed ({error})", "compress it again") from None


def unpack_zlib(content: bytes, bounds: Bounds) -> bytes:
    """What zlib has packed.

    Raises:
        ValueError: it is broken, or unpacks to more than ``bounds.room``.
    """
    room = bounds.room(len(content))
    try:
        worker = zlib.decompressobj()
        result = worker.decompress(content, room)
        if not worker.eof:
            raise ValueError("it ends too early" if not worker.unconsumed_tail else f"it holds more than {room} bytes")
    except zlib.error as error:
        raise ValueError(str(error)) from None
    return result


class _Limited(io.RawIOBase):
    """Hands on what another stream gives, up to a number of bytes."""

    def __init__(self, stream: gzip.GzipFile, where: str, room: int) -> None:
        self._stream, self._where, self._room = stream, where, room
        self._left = room

    def read(self, size: int = -1) -> bytes:
        data = self._stream.read(self._left + 1 if size < 0 else min(size, self._left + 1))
        self._left -= len(data)
        if self._left < 0:
            what = f"unpacks to more than {self._room / 1e6:.0f} MB"
            raise InputError(self._where, what, "give a smaller file, or one that is not compressed")
        return data
