"""Repair states of a version without worth, handed on beside those of this one."""

import math

import pytest

from roadmend.core.command import Command
from roadmend.core.repair import Repair, RepairStatus
from roadmend.recording import messages
from roadmend.recording.codec import Codec, encode
from roadmend.recording.definitions import Definition, computed_hash, find
from roadmend.recording.deviation import deviations
from roadmend.recording.info import bag_info
from roadmend.recording.new_bag import BagCopy, new_bag
from roadmend.recording.reader import BagReader
from roadmend.recording.replay import ReplaySource, check_definition
from roadmend.recording.writer import BagWriter

STATE = "roadmend_msgs/msg/RepairState"
NEW = messages.repair_message_of(
    Repair(Command(0.0, 0.6), RepairStatus.REPAIRED, 0.8, 0.5, 0.3, -0.6, True, 3, (), "near"),
    "rss",
    messages.header_at(0),
)


@pytest.fixture
def earlier(tmp_path):
    """A bag with a text and a repair state by the definition of before."""
    whole = find(STATE).text.splitlines(keepends=True)
    place = next(number for number, line in enumerate(whole) if line.startswith("float64 worth"))
    text = "".join(whole[:place] + whole[place + 2 :])  # the field and the second line of its comment
    definition = Definition(STATE, text, computed_hash(STATE, text))
    with BagWriter(tmp_path / "earlier") as writer:
        writer.add_topic("/repair/state", STATE, (), definition)
        writer.add_topic("/note", "std_msgs/msg/String")
        writer.write("/repair/state", 0, Codec().encode(definition, NEW))
        writer.write("/note", 0, b"\x00\x01\x00\x00\x02\x00\x00\x00a\x00")
    return BagReader(tmp_path / "earlier")


def test_an_earlier_bag_is_read_as_it_is(earlier):
    (state, _) = (message.value for message in earlier.messages())
    assert not hasattr(state, "worth")
    assert messages.repair_of(state) == messages.repair_of(NEW)
    assert [account.worth for account in bag_info(earlier.path).spells] == [None]


def test_a_copy_holds_one_definition_of_a_type(earlier, tmp_path):
    with new_bag(tmp_path / "copy") as writer:
        BagCopy(earlier, writer).until(math.inf)
        writer.add_topic("/shadow/repair/state", STATE)
        writer.write("/shadow/repair/state", 0, encode(NEW))
    reader = BagReader(tmp_path / "copy")
    assert reader.definitions[STATE].type_hash == find(STATE).type_hash
    copied, note, added = reader.messages()
    assert note.value.data == "a"
    assert not deviations(copied.value, added.value)
    assert math.isnan(copied.value.worth)


def test_a_replay_publishes_what_this_version_reads(earlier):
    check_definition(earlier, "/repair/state")
    (tick,) = ReplaySource(earlier, ["/repair/state", "/note"]).ticks()
    state, note = tick.records
    assert state.data == encode(NEW)
    assert note.data == next(earlier.records(["/note"])).data


def test_two_versions_of_a_message_are_compared_in_what_both_tell(earlier):
    old = next(earlier.messages(["/repair/state"])).value
    assert deviations(old, NEW) == deviations(NEW, old) == {}
    old.score = 0.9
    assert deviations(old, NEW).keys() == deviations(NEW, old).keys() == {"score"}
