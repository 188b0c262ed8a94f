"""Labels from what nodes have announced."""

import json

import pytest

from roadmend.nodes.announcement import UNKNOWN, Announcement, account

OURS = {"role": "policy", "node_class": "roadmend.nodes.policy.PolicyNode", "parameters.modular.headway": "1.5"}
REPAIR = {
    "role": "repair",
    "node_class": "roadmend.nodes.repair.RepairNode",
    "parameters.seed": "7",
    "threshold": "0.4",
}
SIM = {"role": "sim", "node_class": "roadmend.nodes.sim.SimNode", "parameters.clock": '"realtime"'}


def graph(**others):
    known = {
        "/policy_node": Announcement("/policy_node", "modular", OURS),
        "/repair_node": Announcement("/repair_node", "adreft", REPAIR),
        "/sim_node": Announcement("/sim_node", "s", SIM),
    }
    return known | {f"/{name}": Announcement(f"/{name}", label, {}) for name, label in others.items()}


def test_who_sent_the_commands_is_who_drove():
    known = account(graph(idle="never drove"), ["/policy_node"], ["/repair_node"])
    assert (known["policy"], known["method"], known["clock"], known["seed"]) == ("modular", "adreft", "realtime", "7")
    assert (known["policy_node"], known["method_threshold"]) == ("/policy_node", "0.4")
    assert json.loads(known["policy_parameters"]) == {"modular.headway": 1.5}
    assert json.loads(known["configuration"])["/idle"]["label"] == "never drove"


@pytest.mark.parametrize(
    ("drivers", "label"),
    [
        (["/mine"], "external:/mine"),  # it has announced nothing
        (["/named"], "external:modular"),  # a node of somebody else's is never taken for ours
        (["/policy_node", "/mine"], "external:/mine + modular"),
        ([], "modular"),
    ],
)
def test_nodes_of_others_are_marked_as_such(drivers, label):
    assert account(graph(named="modular"), drivers, ["/repair_node"])["policy"] == label


def test_of_several_the_details_are_in_the_configuration_alone():
    known = account(graph(), ["/policy_node", "/mine"], [])
    assert "policy_parameters" not in known
    assert known["policy_node"] == "/mine + /policy_node"


def test_where_nobody_was_heard_of_it_is_unknown():
    assert account({}, [], [])["policy"] == account({}, [], [])["method"] == UNKNOWN


def test_as_a_dictionary_parameters_stand_apart():
    told = Announcement("/a", "b", {"role": "policy", "parameters.x": "[1, 2]", "parameters.y": "no JSON"}).as_dict()
    assert told == {"label": "b", "role": "policy", "parameters": {"x": [1, 2], "y": "no JSON"}}
