"""Files that ask for far more than they are: each is written by a function of its path."""

import gzip
import json
import os
import struct
import zlib
from io import BytesIO

import lz4.frame
import zstandard
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, ChunkIndex, DataEnd, Footer, Header, Schema, Statistics
from mcap.writer import MCAP0_MAGIC

PIECE = 60 << 20  # [bytes] of a chunk before compression
CHUNKS = 96  # times a piece: 6 GB

_ALIASES = "a0: &a0 [x,x,x,x,x,x,x,x,x,x]\n" + "".join(
    f"a{level + 1}: &a{level + 1} [{','.join([f'*a{level}'] * 10)}]\n" for level in range(12)
)
_ENTITIES = "".join(f'<!ENTITY e{level + 1} "{f"&e{level};" * 10}">' for level in range(12))
_PICTURE = struct.pack(">IIBBBBB", 60_000, 60_000, 8, 2, 0, 0, 0)


def _png(kind: bytes, content: bytes) -> bytes:
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))


def _sparse(path):
    path.touch()
    os.truncate(path, 1 << 36)


HOSTILE = {
    "empty": lambda path: path.touch(),
    "folder": lambda path: path.mkdir(),
    "fifo": os.mkfifo,
    "endless": lambda path: path.symlink_to("/dev/zero"),
    "loop": lambda path: path.symlink_to(path.name),
    "huge": _sparse,
    "bytes": lambda path: path.write_bytes(bytes(range(256)) * 8),
    "latin": lambda path: path.write_bytes("name: Müller\n".encode("latin-1")),
    "surrogate": lambda path: path.write_text('{"name": "\\ud800", "format": "\\ud800"}'),
    "deep": lambda path: path.write_text("[" * 1_000_000),
    "deep_closed": lambda path: path.write_text('{"a":' * 900 + "1" + "}" * 900),
    "deep_block": lambda path: path.write_text("- " * 100_000),
    "digits": lambda path: path.write_text(f'{{"seed": {"9" * 6000}}}'),
    "sexagesimal": lambda path: path.write_text("seed: 1" + ":10" * 500_000),
    "aliases": lambda path: path.write_text(_ALIASES),
    "merges": lambda path: path.write_text(_ALIASES.replace("[", "{<<: [").replace("]", "]}").replace("x", "{}")),
    "itself": lambda path: path.write_text("a: &a [*a]"),
    "twice": lambda path: path.write_text('{"name": "x", "name": "y"}'),
    "tagged": lambda path: path.write_text("a: !!int ''\nb: !!timestamp x\nc: !!bool 7"),
    "object": lambda path: path.write_text("!!python/object/apply:os.system [true]"),
    "entities": lambda path: path.write_text(f'<!DOCTYPE n [<!ENTITY e0 "x">{_ENTITIES}]><net>&e12;</net>'),
    "external": lambda path: path.write_text('<!DOCTYPE n [<!ENTITY e SYSTEM "/etc/passwd">]><net>&e;</net>'),
    "elements": lambda path: path.write_text("<net>" + "<edge>" * 100_000),
    "no_numbers": lambda path: path.write_text('<net><edge id="a"><lane id="b" shape="x"/></edge></net>'),
    "gzip": lambda path: path.write_bytes(gzip.compress(b"<net>" + bytes(300 << 20), 1)),
    "lying_model": lambda path: path.write_bytes(b"\xff\xff\xff\xff\xff\xff\xff\x7f{}"),
    "model_of_nothing": lambda path: path.write_bytes(
        _model({"w": {"dtype": "F32", "shape": [1 << 40], "data_offsets": [0, 4]}})
    ),
    "deep_model": lambda path: path.write_bytes(_model({"__metadata__": {"roadmend": "[" * 100_000}})),
    "picture": lambda path: path.write_bytes(b"\x89PNG\r\n\x1a\n" + _png(b"IHDR", _PICTURE) + _png(b"IEND", b"")),
    "bag": lambda path: path.write_bytes(bomb()),
    "bag_lying": lambda path: path.write_bytes(bomb(claimed=100)),
    "bag_lz4": lambda path: path.write_bytes(bomb(compression="lz4", claimed=100)),
    "bag_repeated": lambda path: path.write_bytes(bomb(chunks=1, indexed=3000)),
    "bag_summary": lambda path: path.write_bytes(bomb(summary_at_chunks=True)),
}


def _model(header):
    text = json.dumps(header).encode()
    return struct.pack("<Q", len(text)) + text + bytes(8)


def bomb(*, compression="zstd", claimed=PIECE, chunks=CHUNKS, indexed=None, summary_at_chunks=False):
    """An MCAP file that would become gigabytes.

    Args:
        compression: of its chunks.
        claimed: what its index and chunks say of their size before compression.
        chunks: how many there are.
        indexed: how many the index names; the same if not given.
        summary_at_chunks: let the footer name the chunks as its summary.
    """
    content = struct.pack("<BQ", Opcode.MESSAGE, PIECE - 9) + struct.pack("<HIQQ", 1, 1, 1, 1) + bytes(PIECE - 31)
    packed = zstandard.compress(content) if compression == "zstd" else lz4.frame.compress(content)
    chunk = _record(Chunk(compression, packed, 1, 1, 0, claimed))
    schema = _record(Schema(1, b"string data\n", "ros2msg", "std_msgs/msg/String"))
    channel = _record(Channel(1, "/text", "cdr", {}, 1))
    file = BytesIO()
    file.write(MCAP0_MAGIC + _record(Header("ros2", "test")) + schema + channel)
    begin = file.tell()
    file.write(chunk * chunks + _record(DataEnd(0)))
    summary = file.tell()
    file.write(schema + channel + _record(Statistics(0, 1, {1: chunks}, chunks, chunks, 1, 1, 0, 1)))
    for place in range(chunks if indexed is None else indexed):
        offset = begin + len(chunk) * (place % chunks)
        file.write(_record(ChunkIndex(len(chunk), offset, compression, len(packed), 1, 0, {}, 1, claimed)))
    file.write(_record(Footer(begin if summary_at_chunks else summary, 0, 0)) + MCAP0_MAGIC)
    return file.getvalue()


def _record(record) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    return builder.end()
