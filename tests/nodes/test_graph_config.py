"""config/graph.yaml says what the nodes take anyway."""

from pathlib import Path

import pytest
import rclpy
import yaml
from rclpy.parameter import Parameter

from roadmend.nodes.foxglove import FoxgloveParameters
from roadmend.nodes.graph_options import NODES
from roadmend.nodes.policy import PolicyNode
from roadmend.nodes.recorder import RecorderParameters
from roadmend.nodes.repair import RepairNode
from roadmend.nodes.viz import VizParameters

FILE = Path(__file__).parents[2] / "config" / "graph.yaml"


def section(node):
    return yaml.safe_load(FILE.read_text())[f"/**/{node}"]["ros__parameters"]


@pytest.mark.parametrize(
    ("node", "parameters"),
    [
        ("recorder_node", RecorderParameters()),
        ("viz_node", VizParameters()),
        ("foxglove_node", FoxgloveParameters()),
    ],
)
def test_the_observers_defaults(node, parameters):
    for name, value in section(node).items():
        assert getattr(parameters, name) == (tuple(value) if isinstance(value, list) else value)


@pytest.mark.parametrize(("name", "factory"), [("policy_node", PolicyNode), ("repair_node", RepairNode)])
def test_the_drivers_defaults(name, factory, domain):
    rclpy.init()
    try:
        node = factory()
        assert {key: node.get_parameter(key).value for key in section(name)} == section(name)
        node.destroy_node()
    finally:
        rclpy.try_shutdown()


def test_every_node_has_a_section():
    assert set(yaml.safe_load(FILE.read_text())) == {
        f"/**/{node}_node" for node in ("sim", *(entry.node for entry in NODES))
    }
    assert Parameter("clock", value=section("sim_node")["clock"]).type_ == Parameter.Type.STRING
