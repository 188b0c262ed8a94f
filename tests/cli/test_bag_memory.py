"""The commands on bags need no more memory for a large bag than for a small one."""

import subprocess
import sys

import pytest

from roadmend.recording.writer import BagWriter

COMMAND = """
import resource, sys
from roadmend.cli.main import main
code = main(sys.argv[1:])
print(code, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, file=sys.stderr)  # [KB]
"""
LIMIT_KB = 50_000  # that a bag of 150 MB may take more than an empty one
BYTES = "std_msgs/msg/UInt8MultiArray"


@pytest.fixture(scope="module")
def bags(tmp_path_factory):
    """A bag of 150 MB in 7,500 messages, of which compression leaves little, and one of a single message."""
    folder = tmp_path_factory.mktemp("bags")
    data = b"\x00\x01\x00\x00" + bytes(8) + (20_000).to_bytes(4, "little") + bytes(20_000)
    for name, count in (("large", 7_500), ("small", 1)):
        with BagWriter(folder / name) as writer:
            writer.add_topic("/load", BYTES)
            for number in range(count):
                writer.write("/load", number * 1_000_000, data)
    return folder


def memory(folder, *arguments):
    """Peak of a command's resident memory [KB]; the command must succeed."""
    done = subprocess.run(
        [sys.executable, "-c", COMMAND, "bag", *arguments], cwd=folder, capture_output=True, text=True, check=True
    )
    code, peak = done.stderr.split()[-2:]
    assert code == "0", done.stderr
    return int(peak)


@pytest.mark.parametrize(
    "arguments", [("info", "{}"), ("recover", "{}"), ("diff", "{}", "{}"), ("convert", "{}")], ids=lambda one: one[0]
)
def test_memory_does_not_grow_with_the_bag(bags, arguments):
    small, large = (memory(bags, *(word.format(name) for word in arguments)) for name in ("small", "large"))
    assert large - small < LIMIT_KB
