"""A call goes on where an earlier one ended, and only where the files are still those that it made."""

from pathlib import Path

import pytest

from roadmend.core.errors import InputError, SimulationError
from roadmend.safe import driving
from roadmend.safe.cases import CrashCase
from roadmend.safe.driving import Task
from roadmend.safe.planning import do_all, plan
from roadmend.world.scenario_file import load_scenario

from .crashes import HEAD_ON


def build(out, seed):
    """The seeds of the scenarios that the results of a call name, and how many jobs an earlier call had done."""
    told = []
    jobs = plan(Task.BUILD, [CrashCase("head-on", HEAD_ON)], [""], out, samples=1, seed=seed)
    results = do_all(jobs, out, 1, told.append)
    return [load_scenario(out / result.scenario).seed for result in results], told[0]


def test_a_call_with_another_seed_does_not_leave_its_scenarios_to_the_first_one(tmp_path):
    assert build(tmp_path, 1) == ([1, 1], 0)
    assert build(tmp_path, 1) == ([1, 1], 2)
    assert build(tmp_path, 2) == ([2, 2], 0)
    assert build(tmp_path, 1) == ([1, 1], 0)
    assert build(tmp_path, 1) == ([1, 1], 2)
    next((tmp_path / "scenarios").iterdir()).unlink()
    assert build(tmp_path, 1) == ([1, 1], 1)


@pytest.mark.parametrize("error", [SimulationError("the disk is full"), MemoryError()])
def test_what_failed_is_done_again_by_the_next_call(error, tmp_path, monkeypatch):
    def fail(*_):
        raise error

    jobs = plan(Task.BUILD, [CrashCase("head-on", HEAD_ON)], [""], tmp_path)
    with monkeypatch.context() as patch:
        patch.setattr(driving, "draw_scenario", fail)
        assert all(each.note and not each.scenario for each in do_all(jobs, tmp_path, 1, int))
    assert build(tmp_path, 0) == ([0, 0], 0)
    next((tmp_path / "scenarios").iterdir()).unlink()
    with monkeypatch.context() as patch:
        patch.setattr(driving, "draw_scenario", fail)
        assert sum(not each.scenario for each in do_all(jobs, tmp_path, 1, int)) == 1, "not the lost one's old result"
    assert build(tmp_path, 0) == ([0, 0], 1)


def test_a_folder_that_cannot_be_written_ends_the_call_and_is_no_result(tmp_path):
    (tmp_path / "scenarios").symlink_to(tmp_path / "away")
    with pytest.raises(InputError, match="cannot be written"):
        build(tmp_path, 0)
    (tmp_path / "away").mkdir()
    assert build(tmp_path, 0) == ([0, 0], 0)


@pytest.mark.parametrize("names", [("事故一", "事故二"), ("crash 1", "crash-1")])
def test_reports_whose_files_would_have_one_name_are_refused(names, tmp_path):
    cases = [CrashCase(name, HEAD_ON) for name in names]
    with pytest.raises(InputError, match=f"case {names[1]}: is called .* as {names[0]} is"):
        plan(Task.BUILD, cases, [""], tmp_path)
    assert len(plan(Task.BUILD, [cases[0], CrashCase(names[1], None)], [""], tmp_path)) == 2


def test_policies_whose_files_would_have_one_name_are_refused(tmp_path):
    cases = [CrashCase("head-on", HEAD_ON)]
    with pytest.raises(InputError, match=r"policy a-b\.safetensors: is called"):
        plan(Task.TEST, cases, ["a/b.safetensors", "a-b.safetensors"], tmp_path)


def test_a_policy_that_is_named_twice_counts_once():
    once, twice = (plan(Task.TEST, [CrashCase("head-on", HEAD_ON)], ["modular"] * of, Path("out")) for of in (1, 2))
    assert once == twice
