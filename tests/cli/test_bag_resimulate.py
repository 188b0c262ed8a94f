"""``roadmend bag resimulate`` on a run of the real graph."""

import json
from collections import Counter

import pytest
import yaml
from rosbags.highlevel import AnyReader

from roadmend.cli.main import main
from roadmend.recording import messages
from roadmend.recording.codec import encode
from roadmend.recording.reader import BagReader
from roadmend.recording.recorded_run import read_plan, recorded_result
from roadmend.recording.ticks import BagTicks

pytestmark = pytest.mark.graph

AT = 2_000_000_000  # [ns] of the ticks that are altered


@pytest.fixture
def resimulate(recorded, tmp_path, capsys):
    """Runs the command on the recorded run; returns its JSON and the new bag."""

    def run(*arguments):
        out = tmp_path / "out"
        assert main(["bag", "resimulate", str(recorded[0]), *arguments, "--out", str(out), "--json"]) == 0
        return json.loads(capsys.readouterr().out), out

    return run


@pytest.fixture
def refused(recorded, tmp_path, capsys):
    """Runs the command on a bag that it refuses; returns the one line that it says."""

    def run(bag, *arguments):
        before = sorted(tmp_path.iterdir())
        given = ["--repair", "none", *arguments, "--out", str(tmp_path / "out")]
        assert main(["bag", "resimulate", str(bag or recorded[0]), *given]) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert sorted(tmp_path.iterdir()) == before
        return line

    return run


def rows(bag, topic, *names):
    """Some fields of each tick's last message on a topic, by the tick's stamp [s]."""
    found = {}
    for one in BagReader(bag).messages([topic]):
        stamp = one.value.header.stamp
        found[stamp.sec + stamp.nanosec * 1e-9] = [getattr(one.value, name) for name in names]
    return found


def poses(bag):
    return {
        stamp: (pose.pose.position.x, pose.pose.position.y, pose.pose.orientation.z, twist.twist.linear.x)
        for stamp, (pose, twist) in rows(bag, "/ego", "pose", "twist").items()
    }


def test_the_same_method_repeats_the_run_bit_for_bit(recorded, resimulate):
    bag, result = recorded
    told, out = resimulate("--repair", "predictive")
    reader = BagReader(bag)
    assert recorded_result(BagTicks(reader), read_plan(reader)) == result
    assert told["now"] == told["then"]
    assert (told["now"]["outcome"], told["now"]["interventions"]) == (result.outcome.name, result.interventions)
    assert told["now"]["min_distance"] == result.min_distance
    assert poses(out) == poses(bag)
    then, now = (rows(one, "/repair/command", "throttle", "brake", "change_lane") for one in (bag, out))
    assert len(now) == result.ticks
    assert all(then[stamp] == command for stamp, command in now.items())


def test_the_new_bag_is_laid_out_as_one_of_the_graph(recorded, resimulate):
    _, out = resimulate("--repair", "predictive")
    then, now = BagReader(recorded[0]), BagReader(out)
    for name in (
        "/clock",
        "/ego",
        "/objects",
        "/route",
        "/map",
        "/events",
        "/policy/command",
        "/policy/trajectory",
        "/repair/command",
        "/repair/state",
    ):
        recorded_topic, topic = then.topics[name], now.topics[name]
        assert (topic.type_name, topic.type_hash) == (recorded_topic.type_name, recorded_topic.type_hash)
        known, offered = recorded_topic.offers[0], topic.offers[0]
        for policy in ("reliability", "durability", "deadline_ns", "lifespan_ns", "liveliness", "liveliness_lease_ns"):
            assert getattr(offered, policy) == getattr(known, policy), (name, policy)
    drawn = Counter(record.topic for record in now.records())
    assert drawn["/markers/map"] == 1
    assert drawn["/tf"] == drawn["/markers/objects"] == drawn["/markers/ego"] == 81  # every second of 161 ticks
    account = now.metadata["roadmend"]
    assert (account["method"], account["policy"], account["outcome"]) == ("predictive", "modular", "TIMEOUT")
    assert account["resimulated_from"] == "run"
    assert now.attachments == then.attachments
    with AnyReader([out]) as reader:
        assert sum(1 for _ in reader.messages()) == now.count


def test_until_the_moment_the_recorded_commands_are_driven(recorded, resimulate):
    bag, result = recorded
    states = rows(bag, "/repair/state", "intervened")
    acted = [stamp for stamp, (intervened,) in states.items() if intervened]
    moment = acted[len(acted) // 2]
    told, out = resimulate("--repair", "none", "--from-time", f"{moment:.2f}")
    then, now = poses(bag), poses(out)
    assert all(now[stamp] == pose for stamp, pose in then.items() if stamp <= moment + 1e-6)
    assert now[max(now)] != then[max(then)]
    for stamp, (method, intervened) in rows(out, "/repair/state", "method", "intervened").items():
        earlier = stamp < moment - 1e-6
        assert method == ("predictive" if earlier else "none")
        assert intervened == (earlier and states[stamp][0])
    assert told["then"]["interventions"] == result.interventions
    assert told["now"]["interventions"] == len([stamp for stamp in acted if stamp < moment - 1e-6])


def test_a_bag_made_so_can_be_driven_again(resimulate, tmp_path, capsys):
    told, out = resimulate("--repair", "rss", "--set", "rho=1.0")
    again = ["bag", "resimulate", str(out), "--repair", "rss", "--set", "rho=1.0", "--from-time", "4"]
    assert main([*again, "--out", str(tmp_path / "again"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["now"] == told["now"]


def test_the_table_shows_then_and_now(recorded, tmp_path, capsys):
    assert main(["bag", "resimulate", str(recorded[0]), "--repair", "none", "--out", str(tmp_path / "out")]) == 0
    printed = capsys.readouterr().out
    assert "then  predictive  TIMEOUT" in printed
    assert "now   none" in printed


# -- refusals ----------------------------------------------------------------------------------------------------------


def changed(kind, topic, change):
    """Changes the message of a topic at one tick."""

    def keep(record):
        if (record.topic, record.time_ns) != (topic, AT):
            return record.data
        message = kind.decode(record.data)
        change(message)
        return encode(message)

    return keep


def undigested(values):
    """What a bag says of a run, without the digest of its scenario."""
    return {name: value for name, value in values.items() if name != "scenario_sha256"}


def test_another_scenario_than_was_driven_is_refused(altered, refused):
    other = altered(attach=lambda data: yaml.safe_dump(yaml.safe_load(data) | {"seed": 99}).encode())
    assert "altered: crossing.yaml: is not the scenario that was driven" in refused(other)


def test_a_world_that_differs_is_said_to(altered, refused):
    other = altered(attach=lambda data: yaml.safe_dump(yaml.safe_load(data) | {"seed": 99}).encode(), tell=undigested)
    line = refused(other, "--from-time", "6")
    assert "altered: the world differs at " in line
    assert line.endswith("take a bag of a lockstep run of this version, or drive from the start with --from-time 0")


def test_an_ego_elsewhere_is_said_to_be_and_only_before_the_moment(altered, refused, tmp_path):
    def move(message):
        message.pose.pose.position.x += 0.5

    bag = altered(changed(messages.EGO, "/ego", move))
    assert "the world differs at 2.00 s: the ego is 0.5 m from where it was" in refused(bag, "--from-time", "2")
    given = ["--repair", "none", "--from-time", "1.95", "--out", str(tmp_path / "out")]
    assert main(["bag", "resimulate", str(bag), *given]) == 0


def test_objects_that_differ_are_said_to(altered, refused):
    def hasten(message):
        message.speed = message.speed + 1.0

    bag = altered(changed(messages.OBJECTS, "/objects", hasten))
    assert "the world differs at 2.00 s: the speed of the " in refused(bag, "--from-time", "3")


def test_a_policy_that_decides_otherwise_is_said_to(altered, refused):
    def brake(message):
        message.throttle, message.brake = 0.0, 0.75

    bag = altered(changed(messages.COMMAND, "/policy/command", brake))
    line = refused(bag, "--from-time", "3")
    assert "the world differs at 2.00 s: the policy asks for " in line
    assert "then for -0.7500" in line


@pytest.mark.parametrize(
    ("topic", "what"),
    [
        ("/repair/command", "the bag holds no command of the repair node"),
        ("/objects", "the bag holds no scene of this tick"),
        ("/ego", "the bag holds no scene of this tick"),
    ],
)
def test_a_tick_that_is_missing_cannot_be_driven(altered, refused, topic, what):
    bag = altered(lambda record: None if (record.topic, record.time_ns) == (topic, AT) else record.data)
    assert f"the world differs at 2.00 s: {what}" in refused(bag, "--from-time", "3")


def test_a_bag_without_a_usable_scenario_is_refused(altered, refused, recorded):
    for data, what in (
        (None, "altered: carries no scenario; take a bag that 'roadmend run' has recorded"),
        (b"[1, 2]", "altered: crossing.yaml: is no scenario"),
        (b"a: [", "altered: crossing.yaml: is no scenario"),
        (b"name: x\nspeed: 3\n", "altered: crossing.yaml: field "),
    ):
        bag = altered(attach=lambda _, data=data: data, tell=undigested)
        assert what in refused(bag)
        for file in bag.iterdir():
            file.unlink()
        bag.rmdir()


def test_a_policy_that_is_not_named_or_not_here_is_refused(altered, refused):
    bag = altered(tell=lambda values: {name: value for name, value in values.items() if name != "policy"})
    assert "altered: does not say which policy drove" in refused(bag)


@pytest.mark.parametrize("policy", ["external:/mine", "modular + external:/mine"])
def test_a_policy_that_was_a_node_of_somebody_elses_is_refused(altered, refused, policy):
    said = refused(altered(tell=lambda values: {**values, "policy": policy, "policy_is_own": "false"}))
    assert f"was driven by {policy}, a node of somebody else's; a class may drive in its place" in said


def test_a_moment_outside_the_run_is_refused(refused):
    assert "--from-time: 8.05 s is after the end; give 0 to 8 s" in refused(None, "--from-time", "8.05")
    assert "--from-time" in refused(None, "--from-time", "-1")
    assert "--from-time" in refused(None, "--from-time", "nan")
