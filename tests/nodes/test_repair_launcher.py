"""What the two nodes are given; the whole is tried in tests/cli/test_repair.py."""

import pytest

from roadmend.nodes.repair_launcher import _for_others


@pytest.mark.parametrize(
    ("given", "kept"),
    [
        (["-p", "input_timeout:=2.0"], []),
        (["--param", "adreft.model:=x", "-r", "ego:=/odom"], ["-r", "ego:=/odom"]),
        (["-p", "recorder_node:exclude:=camera"], ["-p", "recorder_node:exclude:=camera"]),
        (["--params-file", "p.yaml", "-p", "a:=b:c"], ["--params-file", "p.yaml"]),
        ([], []),
    ],
)
def test_parameters_without_a_nodes_name_are_the_repair_nodes_alone(given, kept):
    assert _for_others(given) == kept
