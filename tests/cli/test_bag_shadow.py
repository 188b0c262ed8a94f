"""``roadmend bag shadow`` on a run of the real graph."""

import json
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
from rosbags.highlevel import AnyReader

from roadmend.cli.main import main
from roadmend.measures.fitting import fitting
from roadmend.recording.reader import BagReader
from roadmend.recording.writer import BagWriter

pytestmark = pytest.mark.graph


@pytest.fixture
def shadow(recorded, tmp_path, capsys):
    """Runs the command on the recorded run; returns its JSON and the new bag."""

    def run(*arguments, bag=None):
        out = tmp_path / "out"
        assert main(["bag", "shadow", str(bag or recorded[0]), *arguments, "--out", str(out), "--json"]) == 0
        return json.loads(capsys.readouterr().out), out

    return run


def by_stamp(bag, topic):
    """The decoded messages of a topic; of a tick that was answered twice, the last."""
    messages = BagReader(bag).messages([topic])
    return {(one.value.header.stamp.sec, one.value.header.stamp.nanosec): one.value for one in messages}


def same(one, other):
    if hasattr(one, "__msgtype__"):
        return all(same(getattr(one, field.name), getattr(other, field.name)) for field in fields(one))
    return np.array_equal(one, other, equal_nan=isinstance(one, float | np.ndarray))


def test_the_method_that_drove_would_do_the_same_again_bit_for_bit(recorded, shadow):
    bag, result = recorded
    told, out = shadow("--repair", "predictive")
    assert (told["ticks"], told["agreement"], told["first_difference"]) == (result.ticks, 1.0, None)
    assert told["interventions_then"] == told["interventions_now"] == result.interventions > 0
    assert told["acceleration_difference"] == 0.0
    for short in ("/repair/state", "/repair/command"):
        then, now = by_stamp(bag, short), by_stamp(out, f"/shadow{short}")
        assert len(now) == result.ticks
        assert all(same(message, then[stamp]) for stamp, message in now.items())


def test_the_shadow_of_a_bag_in_wall_time_lies_in_wall_time(shadow, tmp_path):
    source, begin = BagReader(Path(__file__).parents[2] / "bags" / "samples" / "repaired"), 1_764_000_000 * 10**9
    names = ["/ego", "/objects", "/route", "/events", "/policy/command", "/policy/trajectory", "/repair/state"]
    with BagWriter(tmp_path / "wall") as writer:
        for name in names:
            topic = source.topics[name]
            writer.add_topic(name, topic.type_name, topic.offers, source.definitions[topic.type_name])
        for record in source.records(names):
            if record.time_ns < 2 * 10**9:
                writer.write(record.topic, begin + record.time_ns, record.data)
    _, out = shadow("--repair", "none", bag=tmp_path / "wall")
    made = BagReader(out)
    assert "/shadow/repair/state" in made.topics
    assert made.start_ns >= begin
    assert made.end_ns < begin + 3 * 10**9


def test_another_method_differs_where_the_first_one_stepped_in(recorded, shadow):
    bag, result = recorded
    told, out = shadow("--repair", "none")
    states = by_stamp(bag, "/repair/state")
    begin = min(stamp for stamp, state in states.items() if state.intervened)
    assert told["interventions_now"] == 0
    assert told["agreement"] == pytest.approx(1.0 - result.interventions / result.ticks)
    assert told["first_difference"] == pytest.approx(begin[0] + begin[1] * 1e-9)
    assert told["acceleration_difference"] > 0.1
    assert {state.method for state in by_stamp(out, "/shadow/repair/state").values()} == {"none"}


def test_what_was_recorded_lies_beside_it_as_it_was(recorded, shadow):
    _, out = shadow("--repair", "rss", "--set", "rho=1.0")
    then, now = BagReader(recorded[0]), BagReader(out)
    for name, topic in then.topics.items():
        assert now.topics[name] == topic
        assert [(one.time_ns, one.data) for one in now.records([name])] == [
            (one.time_ns, one.data) for one in then.records([name])
        ]
    assert now.attachments == then.attachments
    assert now.metadata["roadmend"] == then.metadata["roadmend"]
    assert json.loads(now.metadata["roadmend_shadow"]["parameters"]) == {**fitting("rss", "modular"), "rho": 1.0}
    times = [record.time_ns for record in now.records()]
    assert times == sorted(times)
    with AnyReader([out]) as reader:
        assert sum(1 for _ in reader.messages()) == now.count > then.count


def test_a_setting_changes_what_a_method_would_do(shadow, tmp_path):
    mild, out = shadow("--repair", "rss", "--set", "rho=0.0")
    out.rename(tmp_path / "mild")
    wary, _ = shadow("--repair", "rss", "--set", "rho=2.0")
    assert wary["interventions_now"] > mild["interventions_now"]


def test_ticks_that_lack_something_are_answered_with_a_stop_that_says_so(altered, shadow):
    lost = {"/policy/command": 2_000_000_000, "/objects": 3_000_000_000}
    told, out = shadow(
        "--repair",
        "none",
        bag=altered(lambda record: None if lost.get(record.topic) == record.time_ns else record.data),
    )
    assert told["not_asked"] == 2
    assert told["not_asked_why"].startswith("2.00 s: STALE_COMMAND, controlled stop at brake ")
    states = by_stamp(out, "/shadow/repair/state")
    assert states[2, 0].state == states[2, 0].STALE_COMMAND
    assert "the bag lacks the policy's command" in states[2, 0].reason
    assert states[3, 0].state == states[3, 0].STALE_OBJECTS
    assert states[4, 0].state == states[4, 0].PASS


def test_without_a_repair_node_the_policys_command_is_what_was_done(altered, shadow):
    bag = altered(lambda record: None if record.topic.startswith("/repair/") else record.data)
    told, _ = shadow("--repair", "none", bag=bag)
    assert told["interventions_then"] is None
    assert told["agreement"] == 1.0


def test_the_table_names_both(recorded, tmp_path, capsys):
    assert main(["bag", "shadow", str(recorded[0]), "--repair", "none", "--out", str(tmp_path / "out")]) == 0
    printed = capsys.readouterr().out
    assert "of none" in printed
    assert f"{recorded[1].interventions}" in printed


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["--repair", "rss", "--set", "rho=9"], "rss.rho: input should be less than or equal to 3 (got 9.0)"),
        (["--repair", "rss", "--set", "rho"], "--set rho: is no NAME=VALUE; write for example --set rho=0.4"),
        (["--repair", "rss", "--set", "rho=["], "--set rho=[: is no NAME=VALUE"),
        (["--repair", "rss", "--model", "m.safetensors"], "rss.model: is unknown; known are: rho"),
        (["--repair", "adreft", "--model", "m.safetensors"], "m.safetensors: no such model file"),
        (["--repair", "prayer"], "there is no 'prayer'; choose one of"),
    ],
)
def test_a_bad_choice_is_one_line_and_leaves_nothing(recorded, tmp_path, capsys, arguments, line):
    assert main(["bag", "shadow", str(recorded[0]), *arguments, "--out", str(tmp_path / "out")]) == 2
    (said,) = capsys.readouterr().err.splitlines()
    assert line in said.replace("(got 9)", "(got 9.0)")
    assert not list(tmp_path.iterdir())


def test_a_bag_without_an_episode_is_refused(recorded, altered, shadow, tmp_path, capsys):
    bag = altered(lambda record: None if record.topic in {"/route", "/objects"} else record.data)
    assert main(["bag", "shadow", str(bag), "--repair", "rss", "--out", str(tmp_path / "out")]) == 2
    assert f"{bag}: holds no objects and no route" in capsys.readouterr().err
    assert main(["bag", "shadow", str(tmp_path / "none"), "--repair", "rss", "--out", str(tmp_path / "out")]) == 2
    assert "there is no such bag" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_bag_with_a_shadow_and_a_taken_place_are_refused(recorded, shadow, tmp_path, capsys):
    _, out = shadow("--repair", "none")
    assert main(["bag", "shadow", str(out), "--repair", "rss", "--out", str(tmp_path / "two")]) == 2
    assert "has a shadow already" in capsys.readouterr().err
    assert main(["bag", "shadow", str(recorded[0]), "--repair", "rss", "--out", str(out)]) == 2
    assert "exists already" in capsys.readouterr().err


def test_a_bag_that_is_broken_further_on_leaves_nothing(altered, tmp_path, capsys):
    bag = altered()
    (file,) = bag.glob("*.mcap")
    content = file.read_bytes()
    place = len(content) // 2
    file.write_bytes(content[:place] + bytes(64) + content[place + 64 :])
    assert main(["bag", "shadow", str(bag), "--repair", "none", "--out", str(tmp_path / "out")]) == 2
    assert "was cut short or is corrupt" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["altered"]
