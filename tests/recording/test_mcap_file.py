"""One file read by its index: chunks whose times overlap are held together, but no more than is due."""

import pytest

from roadmend.core.errors import InputError
from roadmend.recording import mcap_file
from roadmend.recording.reader import BagReader
from roadmend.recording.writer import BagOptions, BagWriter

BYTES = "std_msgs/msg/UInt8MultiArray"
DATA = b"\x00\x01\x00\x00" + bytes(8) + (1000).to_bytes(4, "little") + bytes(1000)
HELD = 20_000  # [bytes] in place of what a file may hold in memory; chunks have 4 kB


@pytest.fixture
def written(tmp_path, monkeypatch):
    """Writes messages at these times [ns], in this order, and gives a reader of the bag that holds little."""

    def write(times):
        with BagWriter(tmp_path / "bag", options=BagOptions(chunk_size=1 << 12)) as writer:
            writer.add_topic("/load", BYTES)
            for time in times:
                writer.write("/load", time, DATA)
        monkeypatch.setattr(mcap_file, "HELD_MAX", HELD)
        return BagReader(tmp_path / "bag")

    return write


def test_a_long_bag_in_which_every_chunk_overlaps_the_next_is_read_in_order(written):
    times = [1_000_000 * (place + (3 if place % 4 == 3 else 0)) for place in range(200)]  # each fourth comes early
    reader = written(times)
    assert [record.time_ns for record in reader.records()] == sorted(times)


def test_one_whose_chunks_all_overlap_is_refused_before_it_fills_the_memory(written):
    reader = written([1_000_000 * (place if place % 2 else 1000 - place) for place in range(200)])
    with pytest.raises(InputError, match="overlap in time"):
        list(reader.records())
