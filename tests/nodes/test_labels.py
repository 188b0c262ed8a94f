"""What runs is what is recorded: real graphs with every label that can be set wrongly, held against what ran."""

import hashlib
import io
import json
from pathlib import Path

import pytest
import yaml
from rich.console import Console

from roadmend.cli.run import show_results
from roadmend.core.errors import InputError
from roadmend.nodes.graph_options import GraphOptions
from roadmend.nodes.launcher import run_graph
from roadmend.policies.registry import make_policy
from roadmend.recording.reader import BagReader
from roadmend.repair.registry import make_repairer
from roadmend.training.adreft.adjusting import adjust
from roadmend.world.runner import run_episode
from roadmend.world.scenario_file import load_scenario
from tests.core.own_code import METHOD, POLICY

pytestmark = [pytest.mark.graph, pytest.mark.slow]

MODELS = Path(__file__).parents[2] / "config" / "models"


def sha256(path):
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()


@pytest.fixture
def scenario(scenario_file):
    return scenario_file("S3", 3, time_limit=3.0)


@pytest.fixture
def driven(scenario, tmp_path, domain):
    """Runs the graph and returns its result, the bag's record and the states, after holding them against each other."""

    def drive(*ros_arguments, policy="modular", method="rss", tuned=False):
        options = GraphOptions(
            scenario, policy, method, bags=tmp_path, name="bag", viz=False, tuned=tuned, ros_arguments=ros_arguments
        )
        result = run_graph(options)
        reader = BagReader(tmp_path / "bag")
        record = reader.metadata["roadmend"]
        topics = [topic for topic in reader.topics if topic.endswith("/repair/state")]
        states = [message.value for message in reader.messages(topics)]
        table = io.StringIO()
        show_results([result], Console(file=table, width=300))
        as_json = json.loads(json.dumps(result.as_dict()))
        for key in ("policy", "method"):
            assert record[key] == as_json[key]
            assert record[key] in table.getvalue()
        assert {state.method for state in states} == {record["method"]}
        if "method_threshold" in record:
            assert {state.threshold for state in states} >= {float(record["method_threshold"])}
        told = json.loads(record["configuration"])
        assert told.keys() == as_json["configuration"].keys()
        return result, record, states

    return drive


def alone(path, policy, method, parameters=None, seed=0):
    """The same run without a graph."""
    return run_episode(load_scenario(path), make_policy(policy), make_repairer(method, parameters, seed))


def test_a_parameter_file_decides_who_drives_and_repairs(driven, scenario, tmp_path):
    sections = {
        "/**/policy_node": {"ros__parameters": {"policy": "neural"}},
        "/**/repair_node": {"ros__parameters": {"method": "random", "seed": 5, "random": {"probability": 0.7}}},
    }
    (tmp_path / "p.yaml").write_text(yaml.safe_dump(sections))
    result, record, _ = driven("--params-file", str(tmp_path / "p.yaml"))
    assert (record["policy"], record["method"], record["seed"]) == ("neural", "random", "5")
    assert record["policy_model_sha256"] == sha256(MODELS / "neural.safetensors")
    assert json.loads(record["method_parameters"])["random.probability"] == pytest.approx(0.7)
    assert result.episode.digest == alone(scenario, "neural", "random", {"probability": 0.7}, 5).digest


def test_another_model_and_another_scenario_by_the_command_line(driven, scenario_file, tmp_path):
    model = tmp_path / "mine.safetensors"
    adjust(MODELS / "adreft-neural.safetensors", model, 0.4, {}, "")
    other = scenario_file("S1", 4, time_limit=3.0)
    words = ["-p", f"adreft.model:={model}", "-p", "method:=adreft", "-p", f"sim_node:scenario:={other}"]
    result, record, states = driven(*words, "-p", "modular.headway:=2.5", tuned=True)
    assert record["method_model"] == str(model)
    assert record["method_model_sha256"] == sha256(model)
    assert "made for neural" in record["method_fitting"]
    assert {state.threshold for state in states} == {0.4}  # of that model, not of the default one
    assert record["scenario_file"] == other.name
    assert BagReader(tmp_path / "bag").attachments[other.name].data == other.read_bytes()
    policy = make_policy("modular", {"headway": 2.5})
    repairer = make_repairer("adreft", {"model": str(model)})
    assert result.episode.digest == run_episode(load_scenario(other), policy, repairer).digest


def test_renamed_nodes_topics_and_code_from_outside(driven, scenario, own):
    own(POLICY, "their_policies")
    own(METHOD, "their_repairs")
    words = ["-p", "policy:=their_policies:Careful", "-p", "method:=their_repairs:Near"]
    words += ["-r", "policy_node:__node:=driver", "-r", "policy/command:=wheel", "-r", "__ns:=/car"]
    result, record, _ = driven(*words)
    assert (record["policy"], record["method"]) == ("their_policies:Careful", "their_repairs:Near")
    assert (record["policy_node"], record["method_node"]) == ("/car/driver", "/car/repair_node")
    assert record["policy_class"] == "their_policies.Careful"
    assert len(record["method_code_sha256"]) == 64
    assert result.episode.digest == alone(scenario, "their_policies:Careful", "their_repairs:Near").digest


@pytest.mark.parametrize(
    ("policy", "model", "said"),
    [("neural", "neural", "model neural, made for it"), ("deep_sets", "modular", "since none was made for it")],
)
def test_the_model_that_belongs_to_the_policy_is_taken_and_said(driven, scenario, policy, model, said):
    result, record, _ = driven(policy=policy, method="adreft", tuned=True)
    assert record["method_model_sha256"] == sha256(MODELS / f"adreft-{model}.safetensors")
    assert said in record["method_fitting"]
    assert result.episode.digest == alone(scenario, policy, "adreft", {"model": model}).digest


@pytest.mark.parametrize(
    ("words", "where", "said"),
    [
        (("-p", "rss.rhoo:=0.4"), "parameter rss.rhoo", "did you mean rss.rho?"),
        (("-p", "repair_node:metod:=none"), "parameter metod", "repair_node, did you mean method?"),
        (("-p", "repiar_node:method:=none"), "--ros-args", "no node 'repiar_node', did you mean repair_node?"),
        (("-r", "__ns:=/car", "-p", "repair_node:method:=none"), "--ros-args", "but the node is /car/repair_node"),
        (("-r", "__node:=one"), "--ros-args", "gives all nodes one name"),
        (("-p", "/car/repair_node:method:=none"), "ROS arguments", "Couldn't parse parameter override rule"),
    ],
)
def test_an_unknown_name_stops_the_run_with_the_nearest_one(driven, words, where, said):
    with pytest.raises(InputError) as caught:
        driven(*words)
    assert caught.value.where == where
    assert said in caught.value.what


def test_an_unknown_key_of_a_file_stops_the_run_with_the_nearest_one(driven, tmp_path):
    (tmp_path / "p.yaml").write_text("/**:\n  ros__parameters:\n    rss:\n      time_gapp: 0.4\n")
    with pytest.raises(InputError, match=r"parameter rss\.time_gapp: .*did you mean rss\.time_gap\?"):
        driven("--params-file", str(tmp_path / "p.yaml"))
