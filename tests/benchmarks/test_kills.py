"""What a run that was killed or stopped left is judged, by its bag and its exit code too."""

import kills
import pytest

from roadmend.core.journal import entry_key
from roadmend.nodes.graph_options import NODES

GOOD = {"moment": 1.0, "signal": "KILL", "victim": "policy_node", "resume": None, "exit_code": 1, "left": []}
GOOD |= {"changed": [], "traceback": False, "bag": "reads", "begun": True}
LAUNCHER = {"victim": "launcher", "bag": "recovered"}


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"exit_code": 0},
        {"victim": "", "exit_code": 0},
        {"bag": "none", "begun": False},
        {"bag": "recovered"},
        LAUNCHER | {"exit_code": -9},
        LAUNCHER | {"signal": "STOP", "exit_code": -9},
        LAUNCHER | {"signal": "STOP", "resume": 0.5, "exit_code": 0, "bag": "reads"},
        *(LAUNCHER | {"signal": "TERM", "exit_code": code} for code in (-15, 130)),
        LAUNCHER | {"signal": "INT", "exit_code": 130, "bag": "none", "begun": False},
    ],
)
def test_what_a_run_may_leave(changes):
    assert kills.wrong_with(GOOD | changes) == []


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({"bag": "none"}, "lost: it was begun, and nothing is left of it"),
        ({"bag": "not begun"}, "lost: it was begun, and nothing is left of it"),
        ({"bag": "lost: no chunk"}, "lost: no chunk"),
        ({"bag": "none", "begun": False, "exit_code": 0}, "exit code 0, and of the bag: none"),
        ({"bag": "recovered", "exit_code": 0}, "exit code 0, and of the bag: recovered"),
        ({"exit_code": 3}, "exit code 3"),
        ({"exit_code": 2}, "exit code 2"),
        ({"exit_code": -9}, "exit code -9"),
        ({"victim": "", "exit_code": 1}, "exit code 1"),
        (LAUNCHER | {"exit_code": 1}, "exit code 1"),
        (LAUNCHER | {"signal": "TERM", "exit_code": -9}, "exit code -9"),
        (LAUNCHER | {"signal": "STOP", "resume": 4.0, "exit_code": 130}, "exit code 130"),
        ({"left": ["hung"], "exit_code": None}, "hung"),
        ({"changed": ["notes.txt"]}, "changed notes.txt"),
        ({"traceback": True}, "a bare traceback"),
    ],
)
def test_what_it_may_not(changes, fault):
    assert kills.wrong_with(GOOD | changes) == [fault]


def test_a_bag_is_begun_when_something_is_in_its_file(tmp_path):
    assert not kills._is_begun(tmp_path)
    bag = tmp_path / "bags" / "bag"
    bag.mkdir(parents=True)
    (bag / "bag_0.mcap").touch()
    assert not kills._is_begun(tmp_path)
    (bag / "bag_0.mcap").write_bytes(b"x")
    assert kills._is_begun(tmp_path)


def test_a_kept_run_goes_by_the_code_of_every_node_and_of_the_judge():
    assert {f"roadmend.nodes.{entry.node}" for entry in NODES if entry.node != "foxglove"} <= {*kills.CODE}
    assert "kills" in kills.CODE
    assert entry_key(kills.CODE, 1) != entry_key(kills.CODE[1:], 1)
