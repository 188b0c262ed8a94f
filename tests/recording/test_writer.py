import contextlib
import resource
import subprocess
import sys

import pytest
from mcap.exceptions import EndOfFile
from mcap.records import Message
from mcap.stream_reader import StreamReader

from roadmend.core.errors import InputError
from roadmend.recording.errors import RecordingError
from roadmend.recording.reader import BagReader
from roadmend.recording.writer import BagOptions, BagWriter, Compression

TEXT = "std_msgs/msg/String"
KILLED = """
import sys, time
from pathlib import Path
from roadmend.recording.writer import BagWriter
writer = BagWriter(Path(sys.argv[1]))
writer.add_topic("/text", "std_msgs/msg/String")
print("ready", flush=True)
while True:
    now = time.time_ns()
    writer.write("/text", now, bytes(2000))
    print(now, flush=True)
    time.sleep(0.002)
"""


@contextlib.contextmanager
def file_size_limit(size):
    """Writing beyond fails with an OSError, as it does on a full disk."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def times_in_cut(path):
    """Times of the messages that a file without an end still holds."""
    with path.open("rb") as stream, contextlib.suppress(EndOfFile):
        for record in StreamReader(stream).records:
            if isinstance(record, Message):
                yield record.log_time


@pytest.fixture
def bag(tmp_path):
    writer = BagWriter(tmp_path / "bag")
    writer.add_topic("/text", TEXT)
    yield writer
    writer.close()


@pytest.mark.parametrize("compression", list(Compression))
@pytest.mark.parametrize("chunk_size", [1, 1000, 1 << 20])
def test_each_compression_and_chunk_size_reads_back(tmp_path, make, compression, chunk_size):
    with BagWriter(tmp_path / "bag", BagOptions(compression, chunk_size)) as writer:
        writer.add_topic("/text", TEXT)
        for number in range(100):
            writer.write("/text", number, make.text(str(number)))
    messages = list(BagReader(tmp_path / "bag").messages())
    assert [(message.time_ns, message.value.data) for message in messages] == [(n, str(n)) for n in range(100)]


def test_counts_follow_what_is_written(bag, make):
    data = make.text("hello")
    bag.write("/text", 5, data)
    bag.write("/text", 3, data)
    assert (bag.count, bag.bytes) == (2, 2 * len(data))


def test_closing_twice_is_closing_once(bag):
    bag.close()
    content = bag.file.read_bytes()
    bag.close()
    assert bag.file.read_bytes() == content
    assert not bag.is_open


def test_an_exception_in_the_context_leaves_a_complete_bag(tmp_path, make):
    def fail():
        with BagWriter(tmp_path / "bag") as writer:
            writer.add_topic("/text", TEXT)
            writer.write("/text", 1, make.text("before"))
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail()
    assert BagReader(tmp_path / "bag").count == 1


def test_a_closed_bag_takes_nothing(bag, make):
    bag.close()
    for refused in (
        lambda: bag.write("/text", 1, make.text("late")),
        lambda: bag.add_metadata("a", {}),
        lambda: bag.add_attachment("a", "b", b""),
        bag.flush,
    ):
        with pytest.raises(RecordingError, match=r"bag_0\.mcap: the bag is closed"):
            refused()


def test_an_existing_folder_is_not_touched(tmp_path):
    (tmp_path / "bag").mkdir()
    with pytest.raises(InputError, match=r"bag: exists already; choose another name or remove it"):
        BagWriter(tmp_path / "bag")
    assert list((tmp_path / "bag").iterdir()) == []


def test_a_folder_that_cannot_be_made_is_named(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match=r"file/bag: cannot be written \(Not a directory\); choose another folder"):
        BagWriter(tmp_path / "file" / "bag")


def test_missing_parents_are_made(tmp_path):
    BagWriter(tmp_path / "a" / "b" / "bag").close()
    assert (tmp_path / "a" / "b" / "bag" / "metadata.yaml").exists()


def test_an_unannounced_topic_is_an_error(bag):
    with pytest.raises(KeyError, match="/other"):
        bag.write("/other", 1, b"")


def test_a_negative_time_is_an_error(bag):
    with pytest.raises(ValueError, match="/text: time -1 ns is negative"):
        bag.write("/text", -1, b"")


def test_a_topic_keeps_its_type(bag):
    bag.add_topic("/text", TEXT)
    with pytest.raises(InputError, match=r"^/text: has two types, std_msgs/msg/String and std_msgs/msg/Bool; "):
        bag.add_topic("/text", "std_msgs/msg/Bool")


def test_an_unknown_type_is_an_error(bag):
    with pytest.raises(InputError, match="no such message type is installed"):
        bag.add_topic("/new", "absent_msgs/msg/Thing")


@pytest.mark.parametrize("when", ["write", "flush", "close", "attachment", "metadata"])
def test_a_full_disk_is_one_line_with_the_path(tmp_path, make, when):
    writer = BagWriter(tmp_path / "bag", BagOptions(Compression.NONE, 4096, 3600.0))
    writer.add_topic("/text", TEXT)
    with file_size_limit(20_000):
        writer.write("/text", 1, make.text("first"))
        writer.flush()
        actions = {
            "write": lambda: [writer.write("/text", 2, bytes(1000)) for _ in range(1000)],
            "flush": lambda: [writer.write("/text", 2, bytes(30_000)), writer.flush()],
            "close": lambda: [writer.add_metadata("pad", {"pad": "x" * 19_000}), writer.close()],
            "attachment": lambda: writer.add_attachment("a", "b", bytes(100_000)),
            "metadata": lambda: writer.add_metadata("a", {"b": "c" * 100_000}),
        }
        with pytest.raises(RecordingError, match=r"^\S+/bag/bag_0\.mcap: cannot be written \(File too large\)$"):
            actions[when]()
        assert not writer.is_open
        writer.close()
    assert not (tmp_path / "bag" / "metadata.yaml").exists()
    assert next(times_in_cut(tmp_path / "bag" / "bag_0.mcap")) == 1


def test_a_quiet_bag_is_flushed_when_due(tmp_path, make):
    writer = BagWriter(tmp_path / "bag", BagOptions(flush_interval=3600.0))
    writer.add_topic("/text", TEXT)
    writer.write("/text", 1, make.text("x"))
    writer._flush_due = 0.0  # an hour later
    size = writer.file.stat().st_size
    writer.flush_if_due()
    assert writer.file.stat().st_size > size
    size = writer.file.stat().st_size
    writer.flush_if_due()
    assert writer.file.stat().st_size == size
    writer.close()


def test_sigkill_loses_less_than_a_second(tmp_path):
    child = subprocess.Popen([sys.executable, "-c", KILLED, str(tmp_path / "bag")], stdout=subprocess.PIPE, text=True)
    assert child.stdout.readline() == "ready\n"
    written = [int(child.stdout.readline()) for _ in range(500)]
    child.kill()
    written += map(int, child.stdout.read().split())
    child.wait()
    child.stdout.close()
    times = list(times_in_cut(tmp_path / "bag" / "bag_0.mcap"))
    assert times[: len(written)] == written[: len(times)]  # the last one may have been written and not said
    assert written[-1] - times[-1] < 1e9


def test_a_claimed_folder_must_be_there_and_empty(tmp_path):
    with pytest.raises(InputError, match="cannot be written"):
        BagWriter(tmp_path / "missing", claimed=True)
    (tmp_path / "claimed").mkdir()
    BagWriter(tmp_path / "claimed", claimed=True).close()
    with pytest.raises(InputError, match="exists already"):
        BagWriter(tmp_path / "claimed", claimed=True)
