"""The commands on bags need no more memory for a large bag than for a small one."""

import json
import subprocess
import sys

import pytest

from roadmend.recording.writer import BagWriter

COMMANDS = """
import json, resource, sys
from roadmend.cli.main import main
told = [
    (main(["bag", *words]), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)  # [KB]
    for words in json.loads(sys.argv[1])
]
print(json.dumps(told), file=sys.stderr)
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


def memory(folder, commands):
    """Peak of one process's resident memory [KB] after each of the commands, which must succeed."""
    given = [sys.executable, "-c", COMMANDS, json.dumps(commands)]
    done = subprocess.run(given, cwd=folder, capture_output=True, text=True, check=True)
    codes, peaks = zip(*json.loads(done.stderr.splitlines()[-1]), strict=True)
    assert not any(codes), done.stderr
    return peaks


@pytest.mark.parametrize(
    "arguments", [("info", "{}"), ("recover", "{}"), ("diff", "{}", "{}"), ("convert", "{}")], ids=lambda one: one[0]
)
def test_memory_does_not_grow_with_the_bag(bags, arguments):
    small, large = memory(bags, [[word.format(name) for word in arguments] for name in ("small", "large")])
    assert large - small < LIMIT_KB
