"""Each node announces what it is, keeps that up to date, and refuses what it does not have."""

import json
import time

import pytest
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter

from roadmend.nodes import policy, recorder, repair, replay, safe, sera, sim, viz
from roadmend.nodes.configuration import Announcements, ConfigurationAnnouncer, Running
from roadmend.nodes.ros_arguments import SHARED


@pytest.mark.parametrize(
    ("module", "given", "near"),
    [
        (sim, "clok:=lockstep", "clock"),
        (policy, "polcy:=modular", "policy"),
        (policy, "modular.headwy:=1.0", "modular.headway"),
        (policy, "headway:=1.0", "modular.headway"),
        (repair, "rss.rhoo:=0.5", "rss.rho"),
        (recorder, "outpt:=x", "output"),
        (viz, "rates:=1.0", "rate"),
        (replay, "bagg:=x", "bag"),
        (safe, "atempts:=3", "attempts"),
        (sera, "bnk:=x", "bank"),
    ],
)
def test_a_parameter_that_a_node_does_not_have_ends_it_with_the_nearest_name(
    module, given, near, domain, tmp_path, monkeypatch, capfd
):
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path))
    monkeypatch.chdir(tmp_path)
    assert module.main(["node", "--ros-args", "-p", given]) == 2
    (line,) = [line for line in capfd.readouterr().err.splitlines() if line.startswith("roadmend: ")]
    assert line.startswith(f"roadmend: parameter {given.partition(':')[0]}: ")
    assert f"did you mean {near}?" in line
    assert not (tmp_path / "bags").exists()


def test_a_key_of_a_file_that_a_node_does_not_have_ends_it(domain, tmp_path, monkeypatch, capfd):
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path))
    (tmp_path / "p.yaml").write_text("/**/repair_node:\n  ros__parameters:\n    rss: {time_gapp: 0.4}\n")
    assert repair.main(["repair_node", "--ros-args", "--params-file", str(tmp_path / "p.yaml")]) == 2
    assert "parameter rss.time_gapp: " in capfd.readouterr().err


def test_arguments_that_cannot_be_read_are_one_line(domain, tmp_path, monkeypatch, capfd):
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path))
    assert viz.main(["viz_node", "--ros-args", "-p", "nonsense"]) == 2
    assert capfd.readouterr().err.splitlines()[-1].startswith("roadmend: ROS arguments: ")  # rcl says a line before


@pytest.fixture
def pair(domain, monkeypatch):
    """Makes a node and one that listens; both are spun until something holds."""
    monkeypatch.setenv(SHARED, json.dumps(["others"]))
    rclpy.init(args=["test", "--ros-args", "-p", "others:=1"])
    node, listener = Node("speaker"), Node("listener")
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    executor.add_node(listener)

    def until(holds):
        for _ in range(1500):
            executor.spin_once(timeout_sec=0.02)
            if holds():
                return True
        return False

    yield node, listener, until
    executor.shutdown()
    for one in (node, listener):
        one.destroy_node()
    rclpy.try_shutdown()


def test_it_is_heard_by_whoever_comes_later_and_again_when_it_changes(pair):
    node, listener, until = pair
    node.declare_parameter("load", 0.5)
    node.declare_parameter("secret.key", 1)
    label = ["first"]
    configuration = ConfigurationAnnouncer(
        node, "speaker", lambda: Running(label[0], {"class": "a.B"}), lambda name: not name.startswith("secret.")
    )
    configuration.announce()
    time.sleep(0.2)
    changes = []
    heard = Announcements(listener, lambda: changes.append(1))
    assert until(lambda: "/speaker" in heard.by_node)
    said = heard.by_node["/speaker"]
    assert (said.label, said.role, said.values["class"], said.parameters["load"]) == ("first", "speaker", "a.B", 0.5)
    assert "secret.key" not in said.parameters
    assert json.loads(said.values["ignored"]) == ["others"]  # given to all, and not to be complained of here
    label[0] = "second"
    node.set_parameters([Parameter("load", value=0.25)])
    assert until(lambda: heard.by_node["/speaker"].label == "second")
    assert heard.by_node["/speaker"].parameters["load"] == 0.25
    assert len(changes) == 2
    configuration.announce()
    assert configuration.announcement == heard.by_node["/speaker"]
