"""A bag of another stack, written without any message of ours, judged by a repair method."""

import json

import pytest

from roadmend.cli.main import main
from roadmend.core.errors import InputError
from roadmend.recording.foreign_commands import PEDALS, Pedals
from roadmend.recording.foreign_objects import OBJECT_READERS, EgoOutline
from roadmend.recording.foreign_shadow import ForeignTopics, run_foreign_shadow
from roadmend.recording.messages import stamp_of
from roadmend.recording.reader import BagReader
from roadmend.repair.registry import make_repairer

from .foreign_messages import record

TOPICS = ForeignTopics("/odom", "/detections", "/drive/accel")
OPTIONS = ["--ego", "/odom", "--objects", "/detections", "--command", "/drive/accel"]
CAR = EgoOutline(4.8, 1.8)


@pytest.fixture
def bag(tmp_path):
    return record(tmp_path / "bag")


def shadow(bag, method="rss", topics=TOPICS):
    seen = []
    summary = run_foreign_shadow(
        BagReader(bag), topics, make_repairer(method), CAR, PEDALS, lambda time, answer: seen.append((time, answer))
    )
    return summary, seen


def test_the_method_steps_in_before_the_one_who_stands_and_nobody_moves_on_it(bag):
    summary, seen = shadow(bag)
    assert summary.ticks == len(seen) == 100
    assert summary.interventions_then is None
    assert 5 < summary.interventions_now < 100
    assert 102.0 < summary.first_difference < 104.6
    assert 0.0 < summary.agreement < 1.0
    assert summary.acceleration_difference > 0.1
    assert [trigger.object_id for trigger in seen[-20][1].repair.triggers] == [7]


@pytest.mark.parametrize("stamped", [True, False])
def test_what_a_repair_node_did_then_is_what_was_done(tmp_path, stamped):
    bag = tmp_path / "bag"
    record(bag, stamped=stamped)
    bare, answers = shadow(bag)
    then = [answer.repair for _, answer in answers]
    summary, _ = shadow(record(tmp_path / "repaired", repaired=lambda step: then[step // 5], stamped=stamped))
    assert summary.interventions_then == summary.interventions_now == bare.interventions_now
    assert summary.agreement == 1.0 > bare.agreement


def test_an_answer_has_the_stamp_of_its_command_to_the_nanosecond(tmp_path):
    bag = record(tmp_path / "bag", begin=1_753_000_000.1234567)  # by the clock on the wall
    assert main(["bag", "shadow", str(bag), "--repair", "rss", *OPTIONS, "--out", str(tmp_path / "shadow")]) == 0
    reader = BagReader(tmp_path / "shadow")
    stamps = {
        topic: {stamp_of(message.value.header) for message in reader.messages([topic])}
        for topic in ("/drive/accel", "/shadow/repair/state")
    }
    assert stamps["/drive/accel"] == stamps["/shadow/repair/state"]


def test_with_nobody_in_the_way_only_the_start_differs(tmp_path):
    summary, _ = shadow(record(tmp_path / "far", stands_at=900.0))
    assert summary.interventions_now <= 2  # until the detector has seen everyone twice
    assert summary.agreement >= 0.98


def test_where_the_objects_end_it_stops(tmp_path):
    summary, seen = shadow(record(tmp_path / "short", stands_at=900.0, objects_until=2.0))
    assert "no objects: the last" in seen[-1][1].repair.reason
    assert 40 < summary.not_asked < 60
    assert "s: STA" in summary.not_asked_why


def test_answers_that_are_not_the_methods_are_told_apart(bag, monkeypatch, tmp_path, capsys):
    assert shadow(bag)[0].not_asked <= 1
    capsys.readouterr()

    def fail(*_arguments):
        raise ValueError("objects are in the frame 'lidar'")

    monkeypatch.setattr(OBJECT_READERS["vision_msgs/msg/Detection3DArray"], "read", fail)
    assert main(["bag", "shadow", str(bag), "--repair", "rss", *OPTIONS, "--out", str(tmp_path / "shadow")]) == 0
    line = capsys.readouterr().err.splitlines()[-1]
    assert line.startswith("rss: 100 of 100 answers are not its own, first at 100.00 s: STARTING, ")
    assert line.endswith("no objects: objects are in the frame 'lidar'")


def test_the_command_writes_a_bag_beside_which_the_recorded_lies_as_it_was(bag, tmp_path, capsys):
    out = tmp_path / "out"
    assert main(["bag", "shadow", str(bag), "--repair", "rss", *OPTIONS, "--out", str(out), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["ticks"] == 100
    then, now = BagReader(bag), BagReader(out)
    for name in then.topics:
        assert [(one.time_ns, one.data) for one in now.records([name])] == [
            (one.time_ns, one.data) for one in then.records([name])
        ]
    states = [one.value for one in now.messages(["/shadow/repair/state"])]
    assert len(states) == 100
    assert sum(state.intervened for state in states) == told["interventions_now"]
    assert states[-1].method == "rss"
    times = [record.time_ns for record in now.records()]
    assert times == sorted(times)
    topics = json.loads(now.metadata["roadmend_shadow"]["topics"])
    assert topics["objects"] == "/detections"


def test_a_vehicle_has_the_pedals_that_are_named(bag, tmp_path, capsys):
    pedals, then = Pedals(2.0, 6.0), []
    repairer = make_repairer("rss", {"full_brake": 6.0}, guard={"full_brake": 6.0})
    run_foreign_shadow(BagReader(bag), TOPICS, repairer, CAR, pedals, lambda _, answer: then.append(answer.repair))
    repaired = record(tmp_path / "repaired", repaired=lambda step: then[step // 5])
    found = []
    for place, given in enumerate(([], ["--full-throttle", "2", "--full-brake", "6"])):
        out = ["--out", str(tmp_path / f"{place}"), "--json"]
        assert main(["bag", "shadow", str(repaired), "--repair", "rss", *OPTIONS, *given, *out]) == 0
        found.append(json.loads(capsys.readouterr().out))
    plain, named = found
    assert plain["agreement"] < 0.9
    assert named["agreement"] == 1.0
    assert named["interventions_now"] == named["interventions_then"]
    assert json.loads(named["parameters"]) == {"full_brake": 6.0}


def test_who_is_patient_waits_for_objects(tmp_path):
    bag = record(tmp_path / "bag", stands_at=900.0, objects_until=2.0)
    out = ["--input-timeout", "10", "--out", str(tmp_path / "out")]
    assert main(["bag", "shadow", str(bag), "--repair", "rss", *OPTIONS, *out]) == 0
    states = [one.value for one in BagReader(tmp_path / "out").messages(["/shadow/repair/state"])]
    assert not any("no objects: the last" in state.reason for state in states)


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("--ego-width", "11"),
        ("--ego-centre", "-31"),
        ("--full-throttle", "21"),
        ("--full-brake", "0.4"),
        ("--input-timeout", "0"),
        ("--input-timeout", "61"),
    ],
)
def test_ranges_are_those_of_the_node(bag, tmp_path, capsys, option, value):
    given = [*OPTIONS, option, value, "--out", str(tmp_path / "out")]
    assert main(["bag", "shadow", str(bag), "--repair", "rss", *given]) == 2
    assert option in capsys.readouterr().err


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"--ego": "/odometry"}, "--ego /odometry: is not in {bag}; did you mean /odom?"),
        ({"--ego": "/x"}, "--ego /x: is not in {bag}; name one of /odom"),
        (
            {"--objects": "/odom"},
            "--objects /odom: is nav_msgs/msg/Odometry, not {objects}; name one of /detections",
        ),
        ({"--command": ""}, "--command: is not given; name one of /drive/accel"),
    ],
)
def test_what_is_named_wrong_is_one_line_with_what_there_is(bag, tmp_path, capsys, changed, message):
    options = dict(zip(OPTIONS[::2], OPTIONS[1::2], strict=True)) | changed
    words = [word for pair in options.items() for word in pair]
    assert main(["bag", "shadow", str(bag), "--repair", "rss", *words, "--out", str(tmp_path / "out")]) == 2
    assert capsys.readouterr().err == f"roadmend: {message.format(bag=bag, objects=' or '.join(OBJECT_READERS))}\n"
    assert not (tmp_path / "out").exists()


def test_without_topics_it_says_that_it_is_no_bag_of_ours(bag, tmp_path, capsys):
    assert main(["bag", "shadow", str(bag), "--repair", "rss", "--out", str(tmp_path / "out")]) == 2
    assert "name the topics of another stack's bag" in capsys.readouterr().err


def test_a_topic_without_a_message_cannot_be_judged(bag, monkeypatch):
    monkeypatch.setattr(BagReader, "messages", lambda _self, _topics: iter(()))
    with pytest.raises(InputError, match="holds no message on /drive/accel"):
        shadow(bag)
