"""Ways to damage a file, or to put something in its place that asks for far more than it is."""

import gzip
import os
import random
import struct
from collections.abc import Callable
from pathlib import Path

import zstandard

BIG = 1 << 36  # [bytes] that a sparse file says it has
DEPTH = 1_000_000
_ZEROS = bytes(1 << 20)  # bombs are made of them piece by piece: whoever makes them need not have all at once
_PIECE = 60 << 20  # [bytes] of each of the chunks that a bag unpacks to
_CHUNKS = 96
_MAGIC = b"\x89MCAP0\r\n"
_OPCODES = {"header": 1, "footer": 2, "message": 5, "chunk": 6, "end": 15}

Damage = Callable[[Path, bytes, int], None]  # writes the file of this path, given the sound one's bytes, and a seed


def _truncated(path: Path, sound: bytes, seed: int) -> None:
    cut = random.Random(f"cut/{seed}").uniform(0.2, 0.9)
    path.write_bytes(sound[: int(cut * len(sound))])


def _flipped(path: Path, sound: bytes, seed: int) -> None:
    numbers, content = random.Random(f"flip/{seed}"), bytearray(sound)
    for _ in range(16):
        content[numbers.randrange(len(content))] ^= 1 << numbers.randrange(8)
    path.write_bytes(content)


def _foreign(path: Path, _sound: bytes, seed: int) -> None:
    """A picture's head, and noise."""
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + random.Random(f"foreign/{seed}").randbytes(4096))


def _deep(path: Path, sound: bytes, _seed: int) -> None:
    path.write_bytes((b"<a>" if sound.lstrip()[:1] == b"<" else b"[") * DEPTH)


def _endless(path: Path, _sound: bytes, _seed: int) -> None:
    path.symlink_to("/dev/zero")


def _pipe(path: Path, _sound: bytes, _seed: int) -> None:
    os.mkfifo(path)


def _bomb(path: Path, sound: bytes, _seed: int) -> None:
    """As much as possible out of little, in the way that the kind of file allows."""
    if sound.startswith(_MAGIC):
        path.write_bytes(_bag())
    elif sound.lstrip()[:1] == b"<":
        with gzip.open(path, "wb", compresslevel=1) as file:
            file.write(b"<net>")
            for _ in range(300):
                file.write(_ZEROS)
    elif sound[:1].isalpha() or sound[:1] == b"#":  # YAML: what ten aliases of ten aliases ... come to
        lines = ["a0: &a0 [x,x,x,x,x,x,x,x,x,x]"]
        lines += [f"a{level + 1}: &a{level + 1} [{','.join([f'*a{level}'] * 10)}]" for level in range(12)]
        path.write_text("\n".join(lines), encoding="utf-8")
    else:
        path.touch()
        os.truncate(path, BIG)


DAMAGES: dict[str, Damage] = {
    "truncated": _truncated,
    "flipped": _flipped,
    "foreign": _foreign,
    "deep": _deep,
    "endless": _endless,
    "pipe": _pipe,
    "bomb": _bomb,
}


def _bag() -> bytes:
    """A bag of a few hundred kB whose chunks would become 6 GB."""
    begin = struct.pack("<BQHIQQ", _OPCODES["message"], _PIECE - 9, 1, 1, 1, 1)
    compressor = zstandard.ZstdCompressor().compressobj(size=_PIECE)
    zeros = (compressor.compress(_ZEROS[: _PIECE - at]) for at in range(len(begin), _PIECE, len(_ZEROS)))
    packed = b"".join((compressor.compress(begin), *zeros, compressor.flush()))
    body = struct.pack("<QQQI", 1, 1, _PIECE, 0) + _text("zstd") + struct.pack("<Q", len(packed)) + packed
    head = _record("header", _text("ros2") + _text("test"))
    end = _record("end", struct.pack("<I", 0)) + _record("footer", struct.pack("<QQI", 0, 0, 0))
    return _MAGIC + head + _record("chunk", body) * _CHUNKS + end + _MAGIC


def _record(name: str, content: bytes) -> bytes:
    return struct.pack("<BQ", _OPCODES[name], len(content)) + content


def _text(value: str) -> bytes:
    return struct.pack("<I", len(value)) + value.encode()
