"""The described crash is found where it can happen, is the one described, and happens again from the file."""

from dataclasses import replace

import pytest

from roadmend.core.errors import SimulationError
from roadmend.core.outcome import EventKind
from roadmend.policies.registry import make_policy
from roadmend.repair.registry import make_repairer
from roadmend.safe import reproduction
from roadmend.safe.dsl import DescribedCollision
from roadmend.safe.likeness import Likeness
from roadmend.safe.reproduction import NEAREST, REPRODUCED, reproduce, run_trial
from roadmend.world.runner import run_episode
from roadmend.world.scenario_file import load_scenario, save_scenario

from .crashes import ALL, HEAD_ON, crash, role, vehicle
from .lone import LONE, onlooker


@pytest.mark.parametrize("name", ["straight", "rear end"])
def test_a_crash_is_found_and_its_file_shows_it_again(name, tmp_path):
    ego = {"straight": 0, "rear end": 1}[name]
    found = reproduce(role(ALL[name], ego), "modular", 30)
    assert f"-{REPRODUCED}-" in found.scenario.name, found.outcome
    save_scenario(found.scenario, tmp_path / "s.yaml")
    summary = run_episode(load_scenario(tmp_path / "s.yaml"), make_policy("modular"), make_repairer("none"))
    assert summary.outcome is EventKind.COLLISION
    assert summary.digest == found.trial.summary.digest
    again = reproduce(role(ALL[name], ego), "modular", 30)
    assert (again.episodes, again.scenario) == (found.episodes, found.scenario)


def test_who_is_alone_or_was_the_one_that_left_its_lane_is_not_tried():
    for what, ego, words in ((ALL["alone"], 0, "single vehicle"), (HEAD_ON, 1, "no policy is asked")):
        found = reproduce(role(what, ego), "modular", 30)
        assert (found.scenario, found.episodes) == (None, 0)
        assert words in found.outcome


def test_a_vehicle_that_crashes_alone_does_so_before_the_ego():
    found = reproduce(onlooker(LONE["left"]), "modular", 12)
    assert (found.vehicle, found.own.is_reproduced) == (None, True)
    assert found.scenario.name == "sample-onlooker-reproduced-modular"
    assert found.trial.film.ego_name == "ego"


def test_who_turns_round_is_played_as_the_reading_has_it():
    turns = vehicle(action="Turn Left", manoeuvre="U-turn")
    found = reproduce(role(crash("Straight", vehicle(), turns, collisions=[DescribedCollision(1, 2)])), "modular", 36)
    assert Likeness.DESTINATION not in found.own.failed, found.outcome


def test_a_budget_that_runs_out_says_how_near_it_came():
    found = reproduce(role(ALL["parked"], 0), "modular", 2)
    assert (found.scenario, found.episodes) == (None, 2)
    assert "nearest" in found.outcome


def test_no_episode_was_driven_where_none_could_be(monkeypatch):
    def fail(*_arguments):
        raise SimulationError("no room")

    monkeypatch.setattr(reproduction, "run_trial", fail)
    found = reproduce(role(ALL["parked"], 0), "modular", 2)
    assert (found.scenario, found.episodes, found.outcome) == (None, 0, "no room")


def test_the_nearest_is_told_in_metres_and_is_the_least_of_all(monkeypatch):
    gaps = iter([1.0, 5.0, 2.0])

    def drive(scenario, policy):
        trial = run_trial(scenario, policy)
        return replace(trial, summary=replace(trial.summary, min_distance=next(gaps)))

    monkeypatch.setattr(reproduction, "run_trial", drive)
    assert reproduce(role(ALL["parked"], 0), "modular", 3).outcome == "no contact; the nearest was 1.0 m"


def test_another_crash_than_the_described_one_is_called_the_nearest():
    found = reproduce(role(ALL["pile-up"], 0), "modular", 6)
    assert not found.own.is_reproduced
    assert f"-{NEAREST}-" in found.scenario.name
    assert "not v1 and v2" in found.outcome


@pytest.mark.parametrize("report", ["crash 1", "../crash"])
def test_the_nearest_has_a_name_that_a_scenario_may_have_whatever_the_report_is_called(report, tmp_path):
    found = reproduce(role(ALL["pile-up"], 0, report), "modular", 6)
    assert f"-{NEAREST}-" in found.scenario.name, found.outcome
    save_scenario(found.scenario, tmp_path / "out" / f"{found.scenario.name}.yaml")
    assert load_scenario(tmp_path / "out" / f"{found.scenario.name}.yaml") == found.scenario
    assert [each.name for each in tmp_path.iterdir()] == ["out"]
