"""Bags that are there as a whole or not at all."""

import os

import pytest

from roadmend.core.errors import InputError
from roadmend.recording.new_bag import BagCopy, new_bag
from roadmend.recording.qos import Qos
from roadmend.recording.reader import BagReader
from roadmend.recording.writer import BagWriter

NOBODY = 2**22 + 1  # no process of Linux has such a number


def test_a_copy_holds_everything_and_what_was_added_lies_between(corpus, tmp_path, make):
    reader = BagReader(corpus[0])
    with new_bag(tmp_path / "new") as writer:
        copy = BagCopy(reader, writer)
        writer.add_topic("/more", "std_msgs/msg/String", [Qos()])
        middle = (reader.start_ns + reader.end_ns) // 2
        copy.until(middle)
        writer.write("/more", middle, make.text("added"))
        copy.until(float("inf"))
        assert not (tmp_path / "new").exists()
    new = BagReader(tmp_path / "new")
    assert [record for record in new.records() if record.topic != "/more"] == list(reader.records())
    assert [record.time_ns for record in new.records()] == sorted(record.time_ns for record in new.records())
    assert {name: topic for name, topic in new.topics.items() if name != "/more"} == {
        name: topic for name, topic in reader.topics.items() if topic.count
    }
    assert new.attachments == reader.attachments
    assert new.metadata["roadmend"] == reader.metadata["roadmend"]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["corpus", "new"]


def test_nothing_is_left_of_a_bag_that_fails(tmp_path):
    with pytest.raises(ZeroDivisionError), new_bag(tmp_path / "new") as writer:
        writer.add_metadata("roadmend", {"ratio": str(1 / 0)})
    assert not list(tmp_path.iterdir())


def test_a_taken_place_is_refused_and_stays_as_it_was(tmp_path):
    (tmp_path / "new").mkdir()
    with pytest.raises(InputError, match="exists already"), new_bag(tmp_path / "new"):
        pass
    assert [path.name for path in tmp_path.iterdir()] == ["new"]


def test_what_a_killed_call_left_is_no_obstacle(tmp_path):
    (tmp_path / f".new.{NOBODY}-0123abcd.part" / "new").mkdir(parents=True)
    with new_bag(tmp_path / "new"):
        pass
    assert BagReader(tmp_path / "new").count == 0
    assert [path.name for path in tmp_path.iterdir()] == ["new"]


@pytest.mark.parametrize("name", [".new.part/new", f".new.{NOBODY}-0123abcd.part/mine", ".new.OURS-0123abcd.part/new"])
def test_what_another_hides_beside_it_stays(tmp_path, name):
    name = name.replace("OURS", str(os.getpid()))  # not in the parameter: workers must collect the same tests
    (tmp_path / name).mkdir(parents=True)
    with new_bag(tmp_path / "new"):
        pass
    assert (tmp_path / name).is_dir()


def test_a_copy_keeps_when_each_message_was_sent_and_its_number(tmp_path, make):
    with BagWriter(tmp_path / "old") as writer:
        writer.add_topic("/text", "std_msgs/msg/String", [Qos()])
        for number in range(3):
            writer.write("/text", 100 + number, make.text("x"), publish_ns=93 + number, sequence=1000 + number)
    with new_bag(tmp_path / "new") as writer:
        BagCopy(BagReader(tmp_path / "old"), writer).until(float("inf"))
    found = [(one.time_ns, one.publish_ns, one.sequence) for one in BagReader(tmp_path / "new").records()]
    assert found == [(100, 93, 1000), (101, 94, 1001), (102, 95, 1002)]


def test_a_place_that_cannot_be_made_is_refused_with_a_remedy(tmp_path):
    (tmp_path / "file").write_text("somebody's")
    for place in (tmp_path / "file" / "new", tmp_path / "file" / "deep" / "new", tmp_path / ("x" * 300)):
        with pytest.raises(InputError, match=r"cannot be made \(.+\); choose a writable folder"), new_bag(place):
            pass
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
