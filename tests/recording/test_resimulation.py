"""A run that is recorded in this process, driven again with another repair method."""

import json
from dataclasses import replace

import pytest

from roadmend import run, sample_scenario
from roadmend.cli.bag_need import needs_of
from roadmend.cli.bag_repair import RepairChoice, resimulate_bag
from roadmend.cli.main import main
from roadmend.core.errors import InputError
from roadmend.measures.fitting import fitting
from roadmend.recording import messages
from roadmend.recording.codec import encode
from roadmend.recording.layout import RECORD
from roadmend.recording.reader import BagReader
from roadmend.recording.recorded_run import read_plan
from roadmend.recording.writer import BagWriter

NONE = RepairChoice("none", {}, 0)


@pytest.fixture(scope="module")
def driven(tmp_path_factory):
    """A bag of a driver who is not the default one, and what came of it."""
    folder = tmp_path_factory.mktemp("driven") / "bag"
    scenario = sample_scenario("S3", 3).model_copy(update={"time_limit": 4.0})
    result = run(scenario, "modular", "none", policy_parameters={"acceleration": 1.0, "headway": 2.5}, bag=folder)
    assert result.digest != run(scenario, "modular", "none").digest
    return folder, result


@pytest.fixture
def altered(driven, tmp_path):
    """A copy of that bag in which somebody says other things, or the policy asks for something else at 0 s."""

    def copy(tell=None, command=None):
        reader = BagReader(driven[0])
        with BagWriter(tmp_path / "altered") as writer:
            for name, values in reader.metadata.items():
                if name != "rosbag2":
                    writer.add_metadata(name, values | (tell or {} if name == RECORD else {}))
            for one in reader.attachments.values():
                writer.add_attachment(one.name, one.media_type, one.data)
            for record in reader.records():
                writer.add_topic(record.topic, record.type_name, definition=reader.definitions[record.type_name])
                data = record.data
                if command is not None and record.topic == "/policy/command" and record.time_ns == 0:
                    data = encode(replace(messages.COMMAND.decode(data), throttle=command))
                writer.write(record.topic, record.time_ns, data)
        return tmp_path / "altered"

    return copy


@pytest.mark.parametrize("moment", [0.0, 2.0])
def test_who_drove_with_parameters_of_his_own_drives_with_them_again(driven, tmp_path, moment):
    bag, result = driven
    then, now = resimulate_bag(bag, NONE, moment, tmp_path / "out")
    assert now.digest == then.digest
    assert now.digest == result.digest
    again, _ = resimulate_bag(tmp_path / "out", NONE, moment, tmp_path / "again")
    assert again.digest == result.digest
    assert needs_of(bag, 1) == ()


@pytest.mark.parametrize("command", ["shadow", "resimulate"])
def test_settings_that_were_made_for_who_drove_are_said_and_can_be_left(driven, tmp_path, capsys, command):
    call = ["bag", command, str(driven[0]), "--repair", "rss", "--json", "--out"]
    assert main([*call, str(tmp_path / "tuned")]) == 0
    printed = capsys.readouterr()
    assert "rss behind modular: settings tuned for it (rho " in printed.err
    assert choice_in(printed.out) == fitting("rss", "modular") != {}
    assert main([*call, str(tmp_path / "plain"), "--no-tuned"]) == 0
    printed = capsys.readouterr()
    assert printed.err == ""
    assert choice_in(printed.out) == {}


def choice_in(text):
    """The method's parameters in what a command prints."""
    content = json.loads(text)
    return json.loads(content.get("choice", content)["parameters"])


def test_the_graph_names_them_with_the_policy_and_other_versions_had_others(altered):
    told = {"modular.acceleration": 1.5, "modular.of_before": 3, "autostart": True}
    plan = read_plan(BagReader(altered({"policy_parameters": json.dumps(told)})))
    assert plan.policy_parameters == {"acceleration": 1.5}


@pytest.mark.parametrize("text", ["[1]", "{"])
def test_parameters_that_were_altered_are_refused(altered, text):
    with pytest.raises(InputError, match="does not say what its policy's parameters were"):
        read_plan(BagReader(altered({"policy_parameters": text})))


def test_the_decision_of_the_first_tick_counts_as_well(altered, tmp_path):
    with pytest.raises(InputError, match=r"at 0\.00 s: the policy asks for .* then for .*; .* name who drove"):
        resimulate_bag(altered(command=0.123), NONE, 0.0, tmp_path / "out")
    assert not (tmp_path / "out").exists()
