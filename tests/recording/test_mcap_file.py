"""One file read by its index: chunks whose times overlap are held together, but no more than is due; checksums count."""

import struct

import pytest

from roadmend.core.errors import InputError
from roadmend.recording import mcap_file
from roadmend.recording.info import bag_info
from roadmend.recording.reader import BagReader
from roadmend.recording.recovery import recover
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


@pytest.fixture
def sound(tmp_path):
    """A file with five messages and an attachment."""
    with BagWriter(tmp_path / "bag") as writer:
        writer.add_topic("/load", BYTES)
        for time in range(5):
            writer.write("/load", time, DATA)
        writer.add_attachment("scenario.yaml", "application/yaml", b"position: 225.81\n")
    return tmp_path / "bag" / "bag_0.mcap"


def change(path, place, data):
    content = bytearray(path.read_bytes())
    content[place : place + len(data)] = data
    path.write_bytes(content)


def test_a_flipped_bit_of_the_index_is_refused_and_what_it_is_about_comes_back(sound, tmp_path):
    statistics = struct.pack("<QHI", 5, 1, 1)  # messages, schemas, channels
    place = sound.read_bytes().index(statistics)
    change(sound, place, struct.pack("<Q", 7))
    with pytest.raises(
        InputError, match=r"is corrupt \(the checksum of its index is wrong\); .roadmend bag recover. it"
    ):
        BagReader(sound)
    told = ["the index: its checksum is wrong, it may be altered"]
    assert bag_info(sound).missing == told
    assert recover(sound, tmp_path / "new").missing == told
    assert BagReader(tmp_path / "new").count == 5


def test_an_index_without_a_checksum_is_taken_as_it_is(sound):
    change(sound, sound.stat().st_size - 12, bytes(4))
    assert BagReader(sound).count == 5
    assert bag_info(sound).complete


def test_a_flipped_bit_of_an_attachment_is_refused_and_without_a_checksum_taken(sound):
    begin = sound.read_bytes().index(b"225.81\n")
    change(sound, begin, b"3")
    with pytest.raises(InputError, match=r"the checksum of its attachment scenario\.yaml is wrong"):
        _ = BagReader(sound).attachments
    change(sound, begin + 7, bytes(4))
    assert BagReader(sound).attachments["scenario.yaml"].data == b"position: 325.81\n"
