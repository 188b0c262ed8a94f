"""ROS arguments of a graph: to whom they are addressed, and whether anybody has them."""

import json

import pytest

from roadmend.core.errors import InputError
from roadmend.nodes.announcement import Announcement
from roadmend.nodes.ros_arguments import IGNORED, check_addressees, check_taken, shared_parameters, unknown_parameter


@pytest.fixture
def file(tmp_path):
    def write(text):
        (tmp_path / "p.yaml").write_text(text)
        return "--params-file", str(tmp_path / "p.yaml")

    return write


def node(name, *ignored, **parameters):
    values = {f"parameters.{key}": json.dumps(value) for key, value in parameters.items()}
    return Announcement(name, "", {"node_class": "roadmend.nodes.x.X", IGNORED: json.dumps(ignored), **values})


def test_what_names_no_node_is_for_all(file):
    words = ["-p", "rss.rho:=0.4", "-p", "sim_node:rate:=2.0", "--param", "seed:=1", "-r", "ego:=car"]
    words += file("/**:\n  ros__parameters: {rss: {mu: 0.1}}\n/**/viz_node:\n  ros__parameters: {load: 0.1}\n")
    assert shared_parameters(words) == {"rss.rho", "seed", "rss.mu"}


@pytest.mark.parametrize(
    "words",
    [
        ("-p", "sim_node:rate:=2.0"),
        ("-r", "policy_node:__node:=driver", "-p", "driver:policy:=neural"),
        ("-r", "ego:=car"),
        ("-r", "__ns:=/car"),
        (),
    ],
)
def test_a_node_that_there_is_may_be_named(words):
    check_addressees(words)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("-p", "simnode:rate:=2.0"), "no node 'simnode', did you mean sim_node?"),
        (("-r", "polcy_node:ego:=car"), "did you mean policy_node?"),
        (("-r", "__node:=one"), "gives all nodes one name; write policy_node:__node:=one"),
        (("--params-file", "absent.yaml"), "absent.yaml"),
    ],
)
def test_one_that_there_is_not_may_not(words, said):
    with pytest.raises(InputError) as caught:
        check_addressees(words)
    assert said in str(caught.value)


def test_a_section_for_nobody_is_refused(file):
    with pytest.raises(InputError, match=r"'repiar_node', did you mean repair_node\?"):
        check_addressees(file("/**/repiar_node:\n  ros__parameters: {method: none}\n"))


def test_what_one_node_has_is_not_refused():
    check_taken((), [node("/sim_node", "rho", "clok"), node("/repair_node", "mu")], 2)


def test_what_nobody_has_is_refused_once_all_have_spoken():
    said = [node("/sim_node", "clok", clock="lockstep"), node("/repair_node", "clok")]
    check_taken((), said, 3)
    with pytest.raises(InputError, match=r"parameter clok: .*did you mean clock\?"):
        check_taken((), said, 2)


@pytest.mark.parametrize(
    ("section", "is_fine"),
    [("/**/repair_node", True), ("/car/repair_node", True), ("/*/repair_node", True), ("repair_node", False)],
)
def test_a_node_in_a_namespace_must_be_met(file, section, is_fine):
    words = file(f"{section}:\n  ros__parameters: {{method: none}}\n")
    if is_fine:
        check_taken(words, [node("/car/repair_node")], 1)
        return
    with pytest.raises(InputError, match="but the node is /car/repair_node"):
        check_taken(words, [node("/car/repair_node")], 1)


def test_double_stars_are_any_number_of_namespaces(file):
    check_taken(file("/**/repair_node:\n  ros__parameters: {method: none}\n"), [node("/repair_node")], 1)


def test_a_name_without_its_prefix_gets_the_whole_one():
    assert "did you mean rss.time_gap?" in str(unknown_parameter("time_gap", "x", ["rss.time_gap", "seed"]))
