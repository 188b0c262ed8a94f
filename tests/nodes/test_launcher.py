"""The launcher's judgement about its children, without starting any."""

import json
import tempfile
from pathlib import Path
from types import SimpleNamespace

import pytest
import yaml

from roadmend.core.errors import InputError, RoadmendError
from roadmend.nodes import launcher
from roadmend.nodes.children import Child
from roadmend.nodes.graph_options import NODES, GraphOptions, NodeEntry
from roadmend.nodes.launcher import BAD_INPUT, _GraphRun, _raise, run_graph
from roadmend.nodes.ros_arguments import as_yaml
from roadmend.nodes.run_result import RunResult
from roadmend.nodes.supervisor import RESTARTS_MAX


@pytest.fixture
def run(tmp_path):
    options = GraphOptions(Path("s.yaml"), bags=tmp_path / "bags", name="bag")
    return _GraphRun(options, tmp_path / "bags" / "bag", tmp_path, 7, lambda *_: None)


def ended(tmp_path, code, fault=None, *, may_restart=False):
    """A child that has ended and perhaps left why."""
    child = Child("sim_node", "roadmend.nodes.sim", [], {}, tmp_path / "child.log", may_restart)
    child.log.write_text("noise\n")
    if fault is not None:
        child.fault_file.write_text(json.dumps(fault))
    child.process = SimpleNamespace(exitcode=code, pid=None, join=lambda _seconds: None)
    child.start = lambda: None
    return child


FAULT = {"where": "a.yaml", "what": "field seed: no number; really", "mend": "see the schema"}


def test_a_node_that_refuses_its_input_is_an_input_error_with_its_words(tmp_path):
    with pytest.raises(InputError) as caught:
        _raise(ended(tmp_path, BAD_INPUT, FAULT), has_driven=False)
    assert (caught.value.where, caught.value.what, caught.value.mend) == tuple(FAULT.values())


@pytest.mark.parametrize(("fault", "words"), [({"what": "ValueError: bad"}, "ValueError: bad"), ({}, ""), ([], "")])
def test_a_node_that_crashes_is_named_with_code_and_what_it_left_or_its_log(tmp_path, monkeypatch, fault, words):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    with pytest.raises(RoadmendError, match=rf"sim_node failed \(-11\): {words or 'ended'}") as caught:
        _raise(ended(tmp_path, -11, fault), has_driven=False)
    assert not isinstance(caught.value, InputError)
    kept = [*tmp_path.glob("roadmend-sim_node-*.log")]
    assert [path.read_text() for path in kept] == ([] if words else ["noise\n"])
    assert all(str(caught.value).endswith(f"see {path}") for path in kept)


def test_a_node_without_a_log_is_named_with_its_code(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    child = ended(tmp_path, 3)
    child.log.unlink()
    assert str(child.fault()) == "ended (3)"


def test_a_node_that_keeps_dying_ends_the_run(run, tmp_path):
    child = ended(tmp_path, 1, {"what": "ValueError: still broken"}, may_restart=True)
    for restarts in range(1, RESTARTS_MAX + 1):
        run._look_after([child])
        assert child.restarts == restarts
    with pytest.raises(RoadmendError, match=f"sim_node ended {RESTARTS_MAX + 1} times; last: ValueError: still broken"):
        run._look_after([child])


RECORDER = """
import signal
import time
from pathlib import Path

def main(arguments):
    told = []
    signal.signal(signal.SIGINT, lambda *_: told.append(1))
    Path(arguments[1]).write_text("begun")
    while not told:
        time.sleep(0.02)
    time.sleep(1.0)
    Path(arguments[1]).write_text("complete")
"""


def test_where_the_run_fails_the_recorder_is_let_complete_its_bag(run, tmp_path, monkeypatch):
    (tmp_path / "slow_recorder.py").write_text(RECORDER)
    monkeypatch.syspath_prepend(tmp_path)
    bag = tmp_path / "bag.mcap"
    recorder = Child("recorder_node", "slow_recorder", [str(bag)], {}, tmp_path / "recorder.log", may_restart=False)
    child = ended(tmp_path, 1, {"what": "ValueError: still broken"}, may_restart=True)
    child.restarts = RESTARTS_MAX
    run._nodes, run._sim = [recorder, child], ended(tmp_path, None)
    run._sim.process = None
    look_after = run._look_after

    def wait_for_the_bag(children):
        if bag.exists():
            look_after(children)

    monkeypatch.setattr(run, "_look_after", wait_for_the_bag)
    with pytest.raises(RoadmendError, match="sim_node ended 6 times"):
        run.supervise(lambda: False)
    assert (bag.read_text(), recorder.exit_code) == ("complete", 0)


def test_without_a_recorder_it_drives_on_and_says_so_once(run, tmp_path, monkeypatch):
    told = []
    monkeypatch.setattr(run, "_report", lambda text, _time: told.append(text))
    recorder = ended(tmp_path, -9, {"what": "last words"})
    recorder.name = "recorder_node"
    (tmp_path / "sim.begun").touch()
    run._look_after([recorder])
    run._look_after([recorder])
    assert told == ["recorder_node ended (-9), driving on without it: last words"]
    run._nodes = [recorder]
    assert run._recording_error() == "last words"
    recorder.process.exitcode = 0
    assert run._recording_error() == "recorder_node ended before the drive did; the bag ends there"


def test_of_the_nodes_that_were_started_anew_the_result_knows_which_was_the_repair_node(run, monkeypatch):
    monkeypatch.setattr(launcher, "read_result", lambda *_: RunResult(None, "lockstep", 0, 0, 1.0, ""))
    for number, child in enumerate(sorted(run._nodes, key=lambda child: child.name == "repair_node")):
        child.restarts = number
    assert run._result().repair_restarts == len(run._nodes) - 1


def test_a_recorder_that_ends_with_the_drive_is_right(run, tmp_path):
    recorder = ended(tmp_path, 0)
    recorder.name = "recorder_node"
    run._nodes = [recorder]
    assert run._recording_error() == ""


def test_without_a_recorder_that_is_waited_for_nothing_begins(run, tmp_path):
    with pytest.raises(RoadmendError, match=r"sim_node failed \(-9\): last words"):
        run._look_after([ended(tmp_path, -9, {"what": "last words"})])


def test_a_node_that_refuses_its_input_is_not_restarted(run, tmp_path):
    child = ended(tmp_path, BAD_INPUT, FAULT, may_restart=True)
    with pytest.raises(InputError, match="field seed"):
        run._look_after([child])
    assert child.restarts == 0


@pytest.mark.parametrize(
    ("restarts", "has_driven", "words"), [(1, False, "could not be started anew"), (0, True, r"failed \(2\)")]
)
def test_at_a_refusal_in_mid_drive_the_bag_stays(tmp_path, monkeypatch, restarts, has_driven, words):
    def drive(run, _stopped):
        (run._bag / "bag.mcap").write_bytes(b"driven")
        if has_driven:
            (run._folder / "sim.driving").touch()
        child = ended(run._folder, BAD_INPUT, FAULT, may_restart=True)
        child.restarts = restarts
        run._look_after([child])

    monkeypatch.setattr("roadmend.nodes.launcher._GraphRun.supervise", drive)
    with pytest.raises(RoadmendError, match=f"sim_node {words}: a.yaml: field seed") as caught:
        run_graph(GraphOptions(Path("s.yaml"), bags=tmp_path, name="bag"))
    assert not isinstance(caught.value, InputError)
    assert (tmp_path / "bag" / "bag.mcap").read_bytes() == b"driven"


def test_a_node_that_runs_is_left_alone(run, tmp_path):
    child = ended(tmp_path, None, "", may_restart=True)
    run._look_after([child])
    assert child.restarts == 0


@pytest.mark.parametrize(
    ("value", "text"),
    [
        ("on", '"on"'),
        ("1", '"1"'),
        (2.0, "2.0"),
        (3, "3"),
        (True, "true"),
        (["a", "b"], '["a", "b"]'),
        ("fährt \U0001f697", '"fährt \U0001f697"'),
    ],
)
def test_parameters_keep_their_type_on_the_command_line(value, text):
    assert as_yaml(value) == text
    assert yaml.load(text, yaml.CSafeLoader) == value


def test_the_recorder_is_waited_for_and_without_observers_nobody_is(run, tmp_path):
    def started(one):
        names = [child.name for child in one._nodes]
        assert f"wait_for:={json.dumps(names)}" in one._sim.arguments  # everybody who is started is waited for
        return names

    observers = {"recorder_node", "viz_node", "foxglove_node"}
    always = {"policy_node", "repair_node"}
    assert always | {"recorder_node", "viz_node"} <= {*started(run)}
    assert "foxglove_node" not in started(run)
    live = _GraphRun(
        GraphOptions(Path("s.yaml"), record=False, viz=False, foxglove=9000), None, tmp_path, 7, lambda *_: None
    )
    assert observers & {*started(live)} == {"foxglove_node"}
    assert "port:=9000" in next(child for child in live._nodes if child.name == "foxglove_node").arguments
    bare = _GraphRun(GraphOptions(Path("s.yaml"), record=False, viz=False), None, tmp_path, 7, lambda *_: None)
    assert always <= {*started(bare)}
    assert not observers & {*started(bare)}


def test_one_line_adds_a_node_that_every_run_starts(tmp_path, monkeypatch):
    monkeypatch.setattr(launcher, "NODES", (*NODES, NodeEntry("beacon")))
    run = _GraphRun(GraphOptions(Path("s.yaml"), record=False), None, tmp_path, 7, lambda *_: None)
    assert (run._nodes[-1].name, run._nodes[-1].module) == ("beacon_node", "roadmend.nodes.beacon")
    assert any("beacon_node" in word for word in run._sim.arguments)


def test_a_bag_that_is_there_already_is_refused_before_anything_starts(tmp_path, monkeypatch):
    monkeypatch.setattr("roadmend.nodes.launcher._GraphRun", lambda *_: pytest.fail("started"))
    (tmp_path / "bag").mkdir()
    with pytest.raises(InputError, match="exists already; choose another --name"):
        run_graph(GraphOptions(Path("s.yaml"), bags=tmp_path, name="bag"))


def refused(*_):
    raise InputError("seed", "is no number", "give one")


def tree(folder):
    return {str(path.relative_to(folder)): path.is_file() and path.read_bytes() for path in folder.rglob("*")}


@pytest.mark.parametrize("record", [True, False])
@pytest.mark.parametrize("name", ["kept", ".", "..", "a/b", "../kept", "", "new"])
def test_a_run_that_is_refused_removes_nothing_but_its_own(tmp_path, monkeypatch, name, record):
    monkeypatch.setattr("roadmend.nodes.launcher._GraphRun.supervise", refused)
    out = tmp_path / "out"
    (out / "kept").mkdir(parents=True)
    (out / "kept" / "precious.mcap").write_bytes(b"precious")
    before = tree(tmp_path)
    with pytest.raises(InputError):
        run_graph(GraphOptions(Path("s.yaml"), bags=out, name=name, record=record))
    assert tree(tmp_path) == before


def test_of_runs_begun_in_the_same_second_each_has_a_bag_of_its_own(tmp_path, monkeypatch):
    monkeypatch.setattr("roadmend.nodes.launcher.time.strftime", lambda *_: "20260101-000000")
    begun = []

    def drive(run, _stopped):
        (run._bag / "bag.mcap").write_bytes(b"driven")
        begun.append(run._bag.name)

    monkeypatch.setattr("roadmend.nodes.launcher._GraphRun.supervise", drive)
    options = GraphOptions(Path("s.yaml"), bags=tmp_path)
    run_graph(options)
    with monkeypatch.context() as failing:
        failing.setattr("roadmend.nodes.launcher._GraphRun.supervise", refused)
        with pytest.raises(InputError):
            run_graph(options)
    run_graph(options)
    stem = "s-modular-rss-20260101-000000"
    assert begun == [stem, f"{stem}-2"]
    assert sorted(path.name for path in tmp_path.iterdir()) == begun
    assert all((tmp_path / name / "bag.mcap").read_bytes() == b"driven" for name in begun)


def test_a_run_that_recorded_nothing_leaves_no_empty_folder(tmp_path, monkeypatch):
    def die(*_):
        raise RoadmendError("sim_node ended")

    monkeypatch.setattr("roadmend.nodes.launcher._GraphRun.supervise", die)
    with pytest.raises(RoadmendError):
        run_graph(GraphOptions(Path("s.yaml"), bags=tmp_path / "bags", name="bag"))
    assert not (tmp_path / "bags" / "bag").exists()
