"""The yardstick for the recorder: the bare MCAP writer in a loop, without ROS and without anything of ours."""

import time
from collections.abc import Sequence
from pathlib import Path

from mcap.writer import CompressionType, Writer

_COMPRESSION = {"zstd": CompressionType.ZSTD, "lz4": CompressionType.LZ4, "none": CompressionType.NONE}


def time_bare_writing(path: Path, messages: Sequence[bytes], count: int, compression: str) -> float:
    """Seconds that the library's writer takes, with its default chunks.

    Args:
        path: the file to write.
        messages: what to write, over and over.
        count: how many messages.
        compression: zstd, lz4 or none.
    """
    begun = time.perf_counter()
    with path.open("wb") as stream:
        writer = Writer(stream, compression=_COMPRESSION[compression])
        writer.start("ros2")
        schema = writer.register_schema("std_msgs/msg/UInt8MultiArray", "ros2msg", b"uint8[] data")
        channel = writer.register_channel("/load", "cdr", schema)
        for number in range(count):
            writer.add_message(channel, number, messages[number % len(messages)], number, number)
        writer.finish()
    return time.perf_counter() - begun
