"""What is said about bags, whole and cut."""

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from roadmend.cli.main import bag as command
from roadmend.core.errors import InputError
from roadmend.core.outcome import EventKind
from roadmend.recording.definitions import find
from roadmend.recording.foreign_shadow import state_topics
from roadmend.recording.info import bag_info
from roadmend.recording.layout import read_metadata, write_metadata
from roadmend.recording.qos import Qos
from roadmend.recording.reader import BagReader
from roadmend.recording.rhythm import Rhythm
from roadmend.recording.writer import BagWriter

SAMPLES = Path(__file__).parents[2] / "bags" / "samples"
TICK = 50_000_000
NUMBERS = {"uint32": np.uint32, "float64": np.float64}
LATCHED = Qos(depth=1, durability="transient_local")
STATE, EVENT, CLOCK = "roadmend_msgs/msg/RepairState", "roadmend_msgs/msg/ScenarioEvent", "rosgraph_msgs/msg/Clock"


class Maker:
    """Serialized messages from plain values; what is not given is zero or empty."""

    def __init__(self):
        self.store = get_typestore(Stores.EMPTY)
        for name in (STATE, EVENT, CLOCK):
            types = get_types_from_msg(find(name).text, name)
            self.store.register({key: one for key, one in types.items() if key not in self.store.fielddefs})

    def value(self, name, **fields):
        values = dict(fields)
        for field, (node, detail) in self.store.fielddefs[name][1]:
            if node == Nodetype.NAME:
                empty = self.value(detail)
            else:
                empty = (
                    ("" if detail[0] == "string" else 0)
                    if node == Nodetype.BASE
                    else np.zeros(0, NUMBERS.get(detail[0][1][0]))
                )
            values.setdefault(field, empty)
        return self.store.types[name](**values)

    def header(self, tick):
        stamp = self.value("builtin_interfaces/msg/Time", sec=tick // 20, nanosec=tick % 20 * TICK)
        return self.value("std_msgs/msg/Header", stamp=stamp)

    def __call__(self, name, **fields):
        return bytes(self.store.serialize_cdr(self.value(name, **fields), name))


@pytest.fixture
def episode(tmp_path):
    """100 ticks; /clock misses ticks 40 to 49, the repair node steps in at 10 to 14 and at 60."""
    make = Maker()
    with BagWriter(tmp_path / "episode") as writer:
        writer.add_topic("/clock", CLOCK, [Qos()])
        writer.add_topic("/repair/state", STATE, [Qos()])
        writer.add_topic("/events", EVENT, [LATCHED])
        writer.add_metadata("roadmend", {"seed": "7", "method": "rss"})
        writer.add_attachment("scenario.yaml", "application/yaml", b"name: merge\n")
        writer.write("/events", 0, make(EVENT, kind=EventKind.STARTED, text="begin"))
        for tick in range(100):
            acts = 10 <= tick < 15 or tick == 60
            if not 40 <= tick < 50:
                writer.write("/clock", tick * TICK, make(CLOCK))
            done = {
                "state": int(acts),
                "intervened": acts,
                "worth": 0.25 if tick == 10 else np.nan,
                "final_action": -0.4,
            }
            writer.write("/repair/state", tick * TICK, make(STATE, header=make.header(tick), **done))
            if tick % 10 == 9:
                writer.flush()
        writer.write("/events", 99 * TICK, make(EVENT, kind=EventKind.COLLISION, text="hit bus_1"))
        writer.add_metadata("roadmend", {"outcome": "COLLISION", "outcome_text": "hit bus_1"})
    return tmp_path / "episode"


def test_a_whole_bag(episode):
    passed = []
    info = bag_info(episode, passed.append)
    assert sum(passed) == info.bytes == (episode / "episode_0.mcap").stat().st_size
    assert (info.complete, info.missing, info.files) == (True, [], ["episode_0.mcap"])
    assert (info.messages, info.start, info.end) == (192, 0.0, pytest.approx(4.95))
    assert (info.outcome, info.outcome_text) == ("COLLISION", "hit bus_1")
    acts = info.interventions
    assert (acts.ticks, acts.interventions, acts.spells) == (100, 6, 2)
    assert acts.states == {"PASS": 94, "REPAIRED": 6}
    first, second = info.spells
    assert (first.spell.begin, first.spell.ticks, first.strongest, first.worth, first.who) == (0.5, 5, -0.4, 0.25, ())
    assert (second.spell.begin, second.spell.ticks, second.worth) == (3.0, 1, None)
    assert info.metadata["roadmend"]["seed"] == "7"
    assert info.attachments == {"scenario.yaml": 12}
    topics = {topic.name: topic for topic in info.topics}
    clock, state, events = topics["/clock"], topics["/repair/state"], topics["/events"]
    assert (clock.type, clock.count, clock.gaps, clock.out_of_order, clock.latched) == (CLOCK, 90, 1, 0, False)
    assert (clock.longest_gap, clock.longest_gap_at) == (pytest.approx(0.55), pytest.approx(39 * 0.05))
    assert (state.rate, state.gaps) == (pytest.approx(20.0), 0)
    assert (events.count, events.gaps, events.latched) == (2, None, True)


def test_a_bag_that_holds_less_than_its_metadata_promise_is_not_complete(episode):
    metadata = read_metadata(episode)
    clock = next(t for t in metadata["topics_with_message_count"] if t["topic_metadata"]["name"] == "/clock")
    clock["message_count"] = 946
    write_metadata(episode, metadata)
    info = bag_info(episode)
    assert not info.complete
    assert info.missing == ["/clock: 90 of the 946 messages that metadata.yaml promises"]
    assert bag_info(episode / "episode_0.mcap").complete
    metadata["topics_with_message_count"] = [7]
    write_metadata(episode, metadata)
    assert bag_info(episode).complete


def test_a_shadow_in_a_bag_is_not_counted(tmp_path):
    make = Maker()
    with BagWriter(tmp_path / "both") as writer:
        for topic in ("/repair/state", "/shadow/repair/state"):
            writer.add_topic(topic, STATE, [Qos()])
        for tick in range(10):
            writer.write("/shadow/repair/state", tick * TICK, make(STATE, header=make.header(tick), intervened=True))
            writer.write("/repair/state", tick * TICK, make(STATE, header=make.header(tick), intervened=tick == 4))
    acts = bag_info(tmp_path / "both").interventions
    assert (acts.ticks, acts.interventions, acts.spells) == (10, 1, 1)


def test_a_shadow_alone_is_no_intervention_that_happened(tmp_path):
    make = Maker()
    with BagWriter(tmp_path / "shadow") as writer:
        writer.add_topic("/shadow/repair/state", STATE, [Qos()])
        writer.write("/shadow/repair/state", 0, make(STATE, header=make.header(0), intervened=True))
    info = bag_info(tmp_path / "shadow")
    assert info.interventions is None
    assert info.spells == ()
    assert state_topics(BagReader(tmp_path / "shadow")) == []


@pytest.mark.parametrize("name", ["collision", "repaired", "faults"])
def test_it_counts_the_ticks_that_the_spells_are_of(name):
    info = bag_info(SAMPLES / name)
    assert info.interventions.interventions == sum(account.spell.ticks for account in info.spells)
    assert info.interventions.spells == len(info.spells)


def test_a_stamp_that_is_answered_twice_is_one_tick_and_a_final_one_is_none(tmp_path):
    make = Maker()
    with BagWriter(tmp_path / "bag") as writer:
        writer.add_topic("/repair/state", STATE)
        writer.add_topic("/events", EVENT)
        for tick in (0, 1, 1, 2):
            writer.write("/repair/state", tick * TICK, make(STATE, header=make.header(tick), intervened=True))
        end = make(EVENT, header=make.header(2), kind=EventKind.GOAL, text="there")
        writer.write("/events", 2 * TICK, end)
    acts = bag_info(tmp_path / "bag").interventions
    assert (acts.ticks, acts.interventions, acts.spells) == (2, 2, 1)


def test_states_under_another_name_count_as_well(tmp_path):
    make = Maker()
    with BagWriter(tmp_path / "bag") as writer:
        writer.add_topic("/why", STATE)
        writer.write("/why", 0, make(STATE, header=make.header(0), intervened=True))
    info = bag_info(tmp_path / "bag")
    assert info.interventions.interventions == len(info.spells) == 1


def test_what_a_further_file_repeats_is_counted_once_as_the_reader_does(split_corpus):
    folder, written = split_corpus
    info = bag_info(folder)
    assert len(info.files) > 2
    assert info.complete
    assert info.messages == BagReader(folder).count == len(written)
    assert {topic.name: topic.count for topic in info.topics if topic.latched} == {"/route": 1}
    (folder / info.files[0]).unlink()  # then what the next one repeats is all that there is
    assert next(topic.count for topic in bag_info(folder).topics if topic.latched) == 1


@pytest.mark.parametrize("name", ["episode_0.mcap", "metadata.yaml"])
def test_a_bag_may_be_named_by_its_file(episode, name):
    assert bag_info(episode / name).messages == 192


def test_a_cut_bag_tells_what_it_still_can(episode):
    path = episode / "episode_0.mcap"
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 3])
    (episode / "metadata.yaml").unlink()
    info = bag_info(episode)
    assert not info.complete
    assert info.missing[:2] == [
        "metadata.yaml: is missing",
        "the file has no end: its writer was stopped, or the file was cut",
    ]
    assert 0 < info.messages < 192
    assert (info.outcome, info.outcome_text) == ("UNFINISHED", "no final event was recorded")
    assert info.interventions.interventions >= 5
    assert (info.spells[0].spell.begin, info.spells[0].worth) == (0.5, 0.25)


def test_the_command_prints_it_for_people_and_for_programs(episode):
    printed = CliRunner().invoke(command, ["info", str(episode)], catch_exceptions=False).stdout
    assert "verdict" not in printed  # nobody has looked
    for words in (
        "0.50 s  0.25 s  0.10 s      -0.40  +0.25",
        "COLLISION hit bus_1",
        "6 of 100 ticks in 2 spells",
        "0.550 s at 1.950 s",
        "seed",
    ):
        assert words in printed
    read = json.loads(CliRunner().invoke(command, ["info", "--json", str(episode)], catch_exceptions=False).stdout)
    assert read["topics"][0]["name"] == "/clock"
    assert read["interventions"] == {
        "ticks": 100,
        "interventions": 6,
        "spells": 2,
        "states": {"PASS": 94, "REPAIRED": 6},
    }
    assert [(spell["begin"], spell["worth"], spell["need"], spell["verdict"]) for spell in read["spells"]] == [
        (0.5, 0.25, None, None),
        (3.0, None, None, None),
    ]


def test_the_command_that_recovers(episode, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = episode / "episode_0.mcap"
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 3])
    done = CliRunner().invoke(command, ["recover", str(path)], catch_exceptions=False)
    assert "missing: the file has no end" in done.stdout
    assert bag_info(tmp_path / "episode_0-recovered").complete
    again = ["recover", "--json", "--out", "again", "episode_0-recovered"]
    read = json.loads(CliRunner().invoke(command, again, catch_exceptions=False).stdout)
    assert (read["bag"], read["missing"]) == ("again", [])


@pytest.mark.parametrize("name", ["info", "recover"])
def test_a_bag_that_is_not_there(name, tmp_path):
    done = CliRunner().invoke(command, [name, str(tmp_path / "absent")])
    assert isinstance(done.exception, InputError)
    assert "there is no such bag" in str(done.exception)


def test_a_rhythm_without_a_rate_has_no_gaps():
    rhythm = Rhythm()
    for time_ns in (1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024):
        rhythm.add(time_ns)
    assert rhythm.gaps is None


def test_a_rhythm_that_runs_backwards():
    rhythm = Rhythm()
    for time_ns in (5, 4, 9):
        rhythm.add(time_ns)
    assert (rhythm.count, rhythm.back, rhythm.first_ns, rhythm.end_ns) == (3, 1, 4, 9)
    assert rhythm.rate == pytest.approx(2 / 5e-9)


def test_a_rhythm_of_one_moment_has_no_rate():
    rhythm = Rhythm()
    rhythm.add(5)
    assert (rhythm.rate, rhythm.gaps) == (None, None)
