"""src/launch/graph.launch.py against a stand-in of launch, which has no wheel: what it declares and what it starts.

The stand-in takes the arguments that launch and launch_ros of Jazzy take, and no others.
"""

import re
import runpy
import sys
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType

import pytest
import yaml

from roadmend.cli.run import run as run_command
from roadmend.nodes.graph_options import NODES

REPOSITORY = Path(__file__).parents[2]
FILE = REPOSITORY / "src" / "launch" / "graph.launch.py"


@dataclass
class LaunchDescription:
    entities: list


@dataclass
class DeclareLaunchArgument:
    name: str
    default_value: str
    description: str


@dataclass
class OpaqueFunction:
    function: object


@dataclass
class LaunchConfiguration:
    name: str

    def perform(self, context):
        return context[self.name]


@dataclass
class Node:
    package: str
    executable: str
    name: str
    namespace: str
    parameters: list
    ros_arguments: list
    output: str


@dataclass
class SetRemap:
    src: str
    dst: str


@dataclass
class OnProcessExit:
    target_action: Node
    on_exit: object  # entities, or what makes them of the event and the context


@dataclass
class RegisterEventHandler:
    event_handler: OnProcessExit


@dataclass
class Shutdown:
    reason: str


@dataclass
class ProcessExited:
    returncode: int


@dataclass
class EmitEvent:
    event: Shutdown = field(default=None)


STAND_IN = {
    "launch": {"LaunchContext": dict, "LaunchDescription": LaunchDescription},
    "launch.actions": {
        "DeclareLaunchArgument": DeclareLaunchArgument,
        "EmitEvent": EmitEvent,
        "OpaqueFunction": OpaqueFunction,
        "RegisterEventHandler": RegisterEventHandler,
    },
    "launch.event_handlers": {"OnProcessExit": OnProcessExit},
    "launch.events": {"Shutdown": Shutdown},
    "launch.events.process": {"ProcessExited": ProcessExited},
    "launch.substitutions": {"LaunchConfiguration": LaunchConfiguration},
    "launch_ros": {},
    "launch_ros.actions": {"Node": Node, "SetRemap": SetRemap},
}


@pytest.fixture
def description(monkeypatch):
    for name, content in STAND_IN.items():
        module = ModuleType(name)
        vars(module).update(content)
        monkeypatch.setitem(sys.modules, name, module)
    return runpy.run_path(str(FILE))["generate_launch_description"]()


@pytest.fixture
def start(description):
    def entities(**given):
        arguments = [each for each in description.entities if isinstance(each, DeclareLaunchArgument)]
        context = {each.name: each.default_value for each in arguments}
        assert set(given) <= set(context)
        (function,) = [each.function for each in description.entities if isinstance(each, OpaqueFunction)]
        return function({**context, **given})

    return entities


def nodes_of(entities):
    return {each.executable: each for each in entities if isinstance(each, Node)}


def test_everything_is_started_and_the_simulator_waits_for_it(start):
    nodes = nodes_of(start(scenario="s.yaml", foxglove="8765"))
    assert set(nodes) == {f"{entry.node}_node" for entry in NODES} | {"sim_node"}
    assert nodes["sim_node"].parameters[0]["wait_for"] == [name for name in nodes if name != "sim_node"]


def test_what_is_not_wanted_is_not_started(start):
    nodes = nodes_of(start(scenario="s.yaml", record="false", viz="false", policy="external"))
    assert set(nodes) == {"repair_node", "sim_node"}
    assert set(nodes_of(start(sim="false", record="false", viz="false", policy="external"))) == {"repair_node"}


def test_without_the_simulator_repair_and_recorder_stand_alone_and_take_what_comes(start):
    nodes = nodes_of(start(sim="false"))
    assert set(nodes) == {"repair_node", "recorder_node"}
    assert nodes["repair_node"].parameters[0]["inputs"] == "newest"
    assert nodes["recorder_node"].parameters[0]["time_source"] == "system"
    assert "use_sim_time" not in nodes["repair_node"].parameters[0]
    types = {"objects_type": "vision_msgs/msg/Detection3DArray", "command_type": "geometry_msgs/msg/AccelStamped"}
    told = nodes_of(start(sim="false", sim_time="true", **types))
    assert types.items() <= told["repair_node"].parameters[0].items()
    assert told["recorder_node"].parameters[0]["time_source"] == "simulation"
    assert told["repair_node"].parameters[0]["use_sim_time"] is True
    assert set(nodes_of(start(sim="false", policy="modular", viz="true"))) == {*nodes, "policy_node", "viz_node"}


def test_repair_node_counts_by_the_clock_and_the_rate_that_the_simulator_has(start):
    nodes = nodes_of(start(scenario="s.yaml", clock="realtime", rate="0.2"))
    for name in ("sim_node", "repair_node"):
        assert {"clock": "realtime", "rate": 0.2}.items() <= nodes[name].parameters[0].items()


def test_on_command_topics_the_nodes_that_are_started_are_obeyed_and_nobody_else(start):
    nodes = nodes_of(start(scenario="s.yaml"))
    assert nodes["sim_node"].parameters[0]["writer"] == "repair_node"
    assert nodes["repair_node"].parameters[0]["writer"] == "policy_node"
    for others in ({"scenario": "s.yaml", "policy": "external"}, {"sim": "false"}):
        assert nodes_of(start(**others))["repair_node"].parameters[0]["writer"] == ""


def handlers_of(entities):
    handlers = [each.event_handler for each in entities if isinstance(each, RegisterEventHandler)]
    return {handler.target_action.executable: handler.on_exit for handler in handlers}


def test_the_drive_ends_the_run(start):
    (entity,) = handlers_of(start(scenario="s.yaml"))["sim_node"]
    assert isinstance(entity.event, Shutdown)


def test_a_recorder_that_fails_ends_a_run_that_waits_for_it_and_takes_nobodys_repair(start):
    lost = handlers_of(start(scenario="s.yaml"))["recorder_node"]
    assert isinstance(lost(ProcessExited(2), {}).event, Shutdown)
    assert lost(ProcessExited(0), {}) is None
    assert set(handlers_of(start(scenario="s.yaml", record="false"))) == {"sim_node"}
    assert handlers_of(start(sim="false")) == {}


def test_a_bag_that_nobody_names_has_a_name_that_is_free(start):
    first = nodes_of(start(scenario="config/scenarios/demo-exit.yaml"))["recorder_node"].parameters[0]["name"]
    assert re.fullmatch(r"demo-exit-\d{8}-\d{6}", first)
    assert nodes_of(start(sim="false"))["recorder_node"].parameters[0]["name"].startswith("recording-2")
    assert nodes_of(start(scenario="s.yaml", name="mine"))["recorder_node"].parameters[0]["name"] == "mine"


def test_yes_and_no_are_taken_as_people_write_them(start):
    for word in ("no", "False", "0"):
        assert "recorder_node" not in nodes_of(start(scenario="s.yaml", record=word))
    for word in ("yes", "True", "1"):
        assert "recorder_node" in nodes_of(start(scenario="s.yaml", record=word))


def test_nodes_are_remapped_named_and_configured(start):
    entities = start(scenario="s.yaml", remap="/ego:=/car /objects:=/others", namespace="one", params_file="p.yaml")
    remaps = [(each.src, each.dst) for each in entities if isinstance(each, SetRemap)]
    assert remaps == [("/ego", "/car"), ("/objects", "/others")]
    for node in nodes_of(entities).values():
        assert node.namespace == "one"
        assert node.parameters[-1] == "p.yaml"  # behind ours: what it says wins


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({}, "scenario: missing"),
        ({"sim": "no", "remap": "x"}, "'x' is no"),
        ({"sim": "no", "remap": "/ego:= /x:=/y"}, "is no list of FROM:=TO"),
        ({"sim": "off"}, "sim: 'off' is neither true nor false; write sim:=true or sim:=false"),
        ({"scenario": "s.yaml", "record": "flase"}, "record: 'flase' is neither"),
        ({"scenario": "s.yaml", "tuned": "fasle"}, "tuned: 'fasle' is neither"),
        ({"scenario": "s.yaml", "viz": "none"}, "viz: 'none' is neither"),
        ({"sim": "false", "sim_time": "off"}, "sim_time: 'off' is neither"),
        ({"scenario": "s.yaml", "rate": "abc"}, "rate: 'abc' is no number"),
        ({"scenario": "s.yaml", "foxglove": "true"}, "foxglove: 'true' is no whole number"),
        ({"scenario": "s.yaml", "seed": "1.5"}, "seed: '1.5' is no whole number"),
    ],
)
def test_bad_arguments_are_one_line(start, given, message):
    with pytest.raises(RuntimeError, match=message):
        start(**given)


def test_there_is_an_argument_for_what_the_command_line_has(description):
    declared = {each.name for each in description.entities if isinstance(each, DeclareLaunchArgument)}
    options = {option.lstrip("-") for each in run_command.params for option in each.opts if option.startswith("--")}
    of_a_configuration = {
        "sumocfg",
        "net",
        "egos",
        "ego-route",
        "time-limit",
        "warm-up",
    }  # `roadmend run` makes a scenario of it
    of_its_supervisor = {"silence", "start-deadline"}  # launch starts nodes and watches none
    assert options - declared - of_a_configuration - of_its_supervisor - {"json"} == set()


def test_every_parameter_is_one_that_its_node_has(start):
    sections = yaml.safe_load((REPOSITORY / "config" / "graph.yaml").read_text(encoding="utf-8"))
    both = start(scenario="s.yaml", foxglove="8765"), start(sim="false")
    for node in [node for entities in both for node in nodes_of(entities).values()]:
        known = set(sections[f"/**/{node.executable}"]["ros__parameters"]) | {"scenario", "writer"}
        assert set(node.parameters[0]) <= known


def test_every_node_that_is_started_is_a_program_of_the_package(start):
    text = (REPOSITORY / "src" / "setup.py").read_text(encoding="utf-8")
    assert all(f'"{name} = roadmend.nodes.' in text for name in nodes_of(start(scenario="s.yaml", foxglove="1")))
