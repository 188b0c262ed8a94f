"""What the two nodes are given; the whole is tried in tests/cli/test_repair.py."""

import json
import os
from types import SimpleNamespace

import pytest

from roadmend.core.errors import InputError, RoadmendError
from roadmend.nodes import repair_launcher as module
from roadmend.nodes.repair_launcher import BAD_INPUT, RepairGraphOptions, _for_others, _Run, run_repair
from roadmend.nodes.ros_arguments import SHARED
from roadmend.nodes.supervisor import FRESH_S, START_S


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


class Started:
    """A repair node that is there, started by a launcher whose wall clock is in the test's hands."""

    def __init__(self, folder, monkeypatch):
        self.now, self.beats, self.said = 0.0, 0, []
        monkeypatch.setattr(module, "time", SimpleNamespace(monotonic=lambda: self.now))
        self.run = _Run(RepairGraphOptions(record=False), None, folder, self.said.append)
        self.child = self.run._repair
        self.child.start = self.begin
        self.begin()

    def begin(self):
        self.child.pulse.begin()
        self.child.process = SimpleNamespace(exitcode=None, kill=self.kill, join=lambda: None)

    def kill(self):
        self.child.process.exitcode = -9

    def silent(self, seconds):
        """Whether it is still there after so long without a beat."""
        for _ in range(round(seconds / 0.25)):
            self.now += 0.25
            self.run._look_after()
        return not self.said

    def beat(self):
        self.beats += 1
        self.child.pulse.path.touch()
        os.utime(self.child.pulse.path, ns=(self.beats, self.beats))
        self.run._look_after()


def test_a_repair_node_that_compiles_before_its_first_sign_of_life_has_as_long_as_in_a_run(tmp_path, monkeypatch):
    there = Started(tmp_path, monkeypatch)
    assert there.silent(START_S - 1.0)
    assert not there.silent(2.0)
    assert there.said == [f"repair_node hung: no sign of life for {START_S:g} s, restarted"]


def test_one_that_has_been_up_is_waited_for_no_longer_than_one_that_comes_up_anew(tmp_path, monkeypatch):
    there = Started(tmp_path, monkeypatch)
    assert there.silent(FRESH_S + 10.0)
    there.beat()
    assert there.silent(FRESH_S - 1.0)
    assert not there.silent(2.0)
    there.said.clear()
    assert there.silent(FRESH_S - 1.0)  # started anew, when what there is to compile is compiled
    assert not there.silent(2.0)


@pytest.mark.parametrize("restarts", [0, 1])
def test_at_a_refusal_the_bag_stays_where_anything_was_repaired(tmp_path, monkeypatch, restarts):
    def begin(run, _stopped):
        (run._bag / "bag.mcap").write_bytes(b"recorded")
        run._repair.fault_file.write_text(json.dumps({"where": "m", "what": "is cut", "mend": "mend it"}))
        run._repair.process = SimpleNamespace(exitcode=BAD_INPUT, pid=None, join=lambda _seconds: None)
        run._repair.restarts = restarts
        run._look_after()

    monkeypatch.setattr(_Run, "until", begin)
    words = "repair_node could not be started anew: m: is cut" if restarts else "^m: is cut"
    with pytest.raises(RoadmendError, match=words) as caught:
        run_repair(RepairGraphOptions(bags=tmp_path, name="bag"), lambda _text: None)
    assert isinstance(caught.value, InputError) == (not restarts)
    assert (tmp_path / "bag").exists() == bool(restarts)


@pytest.mark.parametrize(
    ("code", "is_early", "words"),
    [
        (0, True, "recorder_node ended before the repair did; the bag ends there"),
        (0, False, ""),
        (1, True, "the disk is full"),
        (1, False, "the disk is full"),
    ],
)
def test_a_recorder_that_ends_before_the_repair_leaves_a_bag_that_is_not_complete(tmp_path, code, is_early, words):
    told = []
    run = _Run(RepairGraphOptions(), tmp_path / "bag", tmp_path, told.append)
    run._recorder.process = SimpleNamespace(exitcode=code)
    run._recorder.fault_file.write_text(json.dumps({"what": "the disk is full"}))
    if is_early:
        run._look_after()
        run._look_after()
    assert len(told) == is_early
    assert run._result().recording_error == words


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("-p", "repair_nod:input_timeout:=0.05"), "no node 'repair_nod', did you mean repair_node?"),
        (("--params-file", "absent.yaml"), "absent.yaml"),
    ],
)
def test_what_is_for_a_node_that_there_is_not_is_refused_before_anything_starts(tmp_path, monkeypatch, words, said):
    monkeypatch.setattr(module, "_Run", lambda *_: pytest.fail("started"))
    with pytest.raises(InputError) as caught:
        run_repair(RepairGraphOptions(bags=tmp_path, name="bag", ros_arguments=words), lambda _text: None)
    assert said in str(caught.value)
    assert not [*tmp_path.iterdir()]


def test_what_a_file_gives_to_all_nodes_only_the_repair_node_must_have(tmp_path):
    file = tmp_path / "p.yaml"
    file.write_text("/**:\n  ros__parameters: {input_timeout: 2.0}\n", encoding="utf-8")
    words = ("--params-file", str(file), "-p", "full_brake:=6.0")
    run = _Run(RepairGraphOptions(ros_arguments=words), tmp_path / "bag", tmp_path, lambda _text: None)
    assert json.loads(run._recorder.environment[SHARED]) == ["input_timeout"]
    assert SHARED not in run._repair.environment


@pytest.mark.parametrize("sim_time", [True, False])
def test_where_the_time_comes_from_the_clock_both_nodes_are_told(tmp_path, sim_time):
    run = _Run(RepairGraphOptions(sim_time=sim_time), tmp_path / "bag", tmp_path, lambda _text: None)
    assert ("use_sim_time:=true" in run._repair.arguments) == sim_time
    assert f'time_source:="{"simulation" if sim_time else "system"}"' in run._recorder.arguments
