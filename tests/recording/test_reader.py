import contextlib
import shutil

import numpy as np
import pytest

from roadmend.core.errors import InputError
from roadmend.recording.qos import Qos
from roadmend.recording.reader import BagReader
from roadmend.recording.writer import BagOptions, BagWriter, Compression


def test_records_come_back_as_written(corpus):
    folder, written = corpus
    reader = BagReader(folder)
    assert [(record.topic, record.time_ns, record.data) for record in reader.records()] == written
    assert (reader.count, reader.start_ns, reader.end_ns) == (len(written), written[0][1], written[-1][1])


def test_messages_are_decoded_by_the_definitions_in_the_file(corpus, make, plain):
    folder, written = corpus
    messages = list(BagReader(folder).messages())
    assert len(messages) == len(written)
    for message, (_, _, data) in zip(messages, written, strict=True):
        assert plain(message.value) == plain(make.store.deserialize_cdr(data, message.type_name))


def test_topics_can_be_chosen(corpus):
    folder, _ = corpus
    assert {record.topic for record in BagReader(folder).records(["/ego", "/tf"])} == {"/ego", "/tf"}
    assert list(BagReader(folder).records(["/absent"])) == []


def test_the_rest_of_the_bag(corpus):
    folder, _ = corpus
    reader = BagReader(folder)
    assert reader.metadata["roadmend"] == {"seed": "7", "outcome": "GOAL"}
    assert reader.attachments["scenario.yaml"].data.decode() == "name: merge ✓\n"
    assert reader.topics["/events"].offers[0] == Qos()
    assert reader.topics["/events"].offers[1].durability == "transient_local"
    assert "/silent" not in reader.topics


def test_messages_out_of_order_are_read_in_order(tmp_path, make):
    with BagWriter(tmp_path / "bag") as writer:
        writer.add_topic("/text", "std_msgs/msg/String")
        for time_ns in (5, 2, 9, 2):
            writer.write("/text", time_ns, make.text(f"{time_ns}"))
    assert [record.time_ns for record in BagReader(tmp_path / "bag").records()] == [2, 2, 5, 9]


def test_an_empty_bag(tmp_path):
    BagWriter(tmp_path / "bag").close()
    reader = BagReader(tmp_path / "bag")
    assert (reader.count, reader.start_ns, reader.end_ns, list(reader.records())) == (0, 0, 0, [])


def test_a_message_that_is_not_of_its_type(tmp_path):
    with BagWriter(tmp_path / "bag") as writer:
        writer.add_topic("/text", "std_msgs/msg/String")
        writer.write("/text", 1, b"\x00\x01\x00\x00\xff\xff\xff\x00")
    with pytest.raises(InputError, match="a message on /text is not a std_msgs/msg/String"):
        list(BagReader(tmp_path / "bag").messages())


def test_a_file_that_metadata_name_but_is_gone(corpus):
    folder, _ = corpus
    (folder / "corpus_0.mcap").unlink()
    with pytest.raises(InputError, match=r"corpus_0\.mcap: is missing"):
        BagReader(folder)


@pytest.mark.parametrize("content", [b"", b"no mcap at all, but long enough to hold a footer and a magic" * 9])
def test_a_file_of_something_else(tmp_path, content):
    (tmp_path / "x.mcap").write_bytes(content)
    with pytest.raises(InputError, match=r"x\.mcap: was cut short or is corrupt \(.+\); .roadmend bag recover. it"):
        BagReader(tmp_path / "x.mcap")


def test_a_file_cut_anywhere_is_refused_in_one_line(corpus, tmp_path):
    folder, _ = corpus
    content = (folder / "corpus_0.mcap").read_bytes()
    cut = tmp_path / "cut.mcap"
    for size in np.linspace(0, len(content) - 1, 60).astype(int):
        cut.write_bytes(content[:size])
        with pytest.raises(InputError) as refused:
            BagReader(cut)
        assert "\n" not in str(refused.value)


@pytest.mark.parametrize("compression", list(Compression))
def test_flipped_bytes_are_found_or_do_no_harm(tmp_path, make, compression):
    with BagWriter(tmp_path / "bag", BagOptions(compression)) as writer:
        writer.add_topic("/text", "std_msgs/msg/String", [Qos()])
        writer.add_metadata("a", {"b": "c"})
        writer.add_attachment("a", "b", b"c" * 50)
        for number in range(20):
            writer.write("/text", number, make.text(f"{number}"))
    content = bytearray((tmp_path / "bag" / "bag_0.mcap").read_bytes())
    flipped = tmp_path / "flipped.mcap"
    random = np.random.default_rng(3)
    refused = 0
    for place in random.choice(len(content), 300, replace=False):
        changed = content.copy()
        changed[place] ^= int(random.integers(1, 256))
        flipped.write_bytes(changed)
        with contextlib.suppress(InputError):  # and no other error
            list(BagReader(flipped).messages())
            refused -= 1
        refused += 1
    assert refused > 30


def test_a_copy_elsewhere_reads_the_same(corpus, tmp_path):
    folder, written = corpus
    shutil.copytree(folder, tmp_path / "elsewhere")
    assert BagReader(tmp_path / "elsewhere").count == len(written)
