"""Searches from end to end: interrupted and not, with one worker and several, in the toy world and in SUMO."""

import dataclasses
import json
import random
import shlex
import shutil
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from roadmend.cli import search as command_of_search
from roadmend.cli.main import main
from roadmend.core.errors import InputError
from roadmend.core.scene import EgoState, ObjectList, Scene
from roadmend.networks.checkpoint import find_model
from roadmend.search import campaign as module
from roadmend.search.attempt import CRASH
from roadmend.search.behaviour import FEATURES, BehaviourRecorder
from roadmend.search.campaign import Campaign, run_campaign, summarise
from roadmend.search.danger import CLOSING_WEIGHT, FARTHEST, HORIZON, Danger
from roadmend.search.evaluation import BEST, CRASH_FITNESS, Evaluation, NamedPoint, Subject, evaluate, evaluate_scenario
from roadmend.search.ledger import Ledger
from roadmend.search.registry import TECHNIQUES, read_technique_parameters
from roadmend.world.families import FAMILIES, sample_scenario
from roadmend.world.scenario_file import load_scenario
from roadmend.world.space import sample

from .toy import made_up

SUSPECTS = [("S5", seed) for seed in (49, *range(300))]  # the first of them collides


def plan(technique, family="S5", seed=1):
    return Campaign(Subject(family, "modular", "none", seed), technique, read_technique_parameters(technique))


def by_value(points):
    """Fitness from the point itself; every seventh or so collides."""
    for _, point in points:
        value = sum(number for number in point.values() if isinstance(number, float)) % 7.0
        outcome = "COLLISION" if value < 1.0 else "GOAL"
        features = tuple(float(point[f"v{slot}.lane"]) for slot in range(6))
        yield made_up(outcome, f"{value}", BEST if value < 1.0 else -value, features)


def search(folder, technique, budget, evaluator=by_value, seed=1):
    with Ledger(folder, plan(technique, seed=seed).settings) as ledger:
        run_campaign(plan(technique, seed=seed), ledger, evaluator, budget)
        return ledger.entries


def content(folder):
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


class StoppedError(Exception):
    pass


@pytest.mark.parametrize("technique", TECHNIQUES)
def test_resumed_equals_uninterrupted(tmp_path, technique):
    search(tmp_path / "whole", technique, 90)

    def breaks(after):
        left = after

        def evaluator(points):
            nonlocal left
            for evaluation in by_value(points):
                if not left:
                    raise StoppedError
                left -= 1
                yield evaluation

        return evaluator

    for after in (0, 1, 20, 7, 31):
        with pytest.raises(StoppedError):
            search(tmp_path / "pieces", technique, 90, breaks(after))
    search(tmp_path / "pieces", technique, 75)  # a budget that ends within a batch
    search(tmp_path / "pieces", technique, 90)
    assert content(tmp_path / "pieces") == content(tmp_path / "whole")
    assert len(content(tmp_path / "whole")) > 2


@pytest.mark.parametrize("technique", TECHNIQUES)
def test_a_spent_budget_runs_nothing(tmp_path, technique):
    first = search(tmp_path, technique, 40)
    assert search(tmp_path, technique, 40, lambda points: iter(()) if not points else pytest.fail("ran")) == first
    assert search(tmp_path, technique, 10, lambda points: iter(()) if not points else pytest.fail("ran")) == first


def test_a_ledger_of_another_version_is_refused(tmp_path, monkeypatch):
    search(tmp_path, "random", 5)
    monkeypatch.setattr(module, "_key", lambda *_: "other")
    with pytest.raises(InputError, match="evaluation 0 is not what this version"):
        search(tmp_path, "random", 9)


def test_a_ledger_of_another_network_is_refused(tmp_path, monkeypatch):
    search(tmp_path, "random", 5)
    monkeypatch.setattr(module, "outside_content", lambda scenario: f"other of {scenario.name}")
    with pytest.raises(InputError, match=r"evaluation 0 is .*of another network; choose another folder"):
        search(tmp_path, "random", 9)


def test_the_tally_counts_what_is_there(tmp_path):
    found = summarise(search(tmp_path, "random", 60))
    assert found.evaluated == 60 == sum(found.outcomes.values())
    assert found.violations == found.outcomes["COLLISION"] == len(list((tmp_path / "found").iterdir()))
    assert 0 < found.distinct <= found.violations
    assert summarise([]).first_violation is None


def command(folder, technique, workers, capsys):
    arguments = ["--family", "S5", "--technique", technique, "--budget", "5", "--seed", "3", "--json"]
    assert main(["search", *arguments, "--workers", str(workers), "--out", str(folder)]) == 0
    return {**json.loads(capsys.readouterr().out), "folder": ""}


@pytest.mark.parametrize("technique", TECHNIQUES)
def test_a_real_search_runs(tmp_path, technique, capsys):
    printed = command(tmp_path, technique, 1, capsys)
    assert (printed["evaluated"], printed["crashes"], printed["technique"]) == (5, 0, technique)
    digests = [
        json.loads(line)["evaluation"]["result"]["digest"]
        for line in (tmp_path / "ledger.jsonl").read_text().splitlines()[1:]
    ]
    assert len(set(digests)) == 5


def test_the_number_of_workers_changes_nothing(tmp_path, capsys):
    one, two = (command(tmp_path / str(workers), "avfuzzer", workers, capsys) for workers in (1, 2))
    assert one == two
    assert content(tmp_path / "1") == content(tmp_path / "2")


def test_a_violation_reproduces_from_its_file(tmp_path, monkeypatch):
    """A scenario that is known to collide is put in the way of the search; its file gives the same trajectory."""
    chosen = next(
        (family, seed)
        for family, seed in SUSPECTS
        if evaluate_scenario(sample_scenario(family, seed), "modular", "none").is_violation
    )
    family, seed = chosen
    point = sample(FAMILIES[family].space, random.Random(f"roadmend/{family}/{seed}"))
    monkeypatch.setattr("roadmend.search.random_draws.sample", lambda *_: point)
    planned = plan("random", family, seed)
    with Ledger(tmp_path, planned.settings) as ledger:
        run_campaign(planned, ledger, partial(map, partial(evaluate, planned.subject)), 1)
    [entry] = ledger.entries
    assert entry.evaluation.fitness == BEST
    again = load_scenario(tmp_path / entry.reproduction.scenario)
    assert entry.reproduction.command.split()[:4] == ["roadmend", "run", "--scenario", entry.reproduction.scenario]
    assert evaluate_scenario(again, "modular", "none") == entry.evaluation


def test_a_point_is_driven_under_the_name_of_its_file(tmp_path):
    """A method that draws numbers goes by the name: under another one the file would show another drive."""
    driven = []

    def collide(points):
        driven.extend(points)
        return iter([made_up("COLLISION", name, BEST, ()) for name, _ in points])

    first, more = search(tmp_path, "random", 2, collide), search(tmp_path, "random", 3, collide)
    assert more[:2] == first
    scenarios = [load_scenario(tmp_path / entry.reproduction.scenario) for entry in more]
    assert [scenario.name for scenario in scenarios] == [point.name for point in driven]
    assert scenarios == [plan("random").subject.scenario(point.parameters, point.name) for point in driven]


@pytest.mark.parametrize("is_absolute", [False, True])
def test_a_model_file_of_the_callers_folder_is_found_from_the_searchs(tmp_path, monkeypatch, is_absolute):
    (tmp_path / "my models").mkdir()
    shutil.copy(find_model("ego_mlp"), tmp_path / "my models" / "mine.safetensors")
    monkeypatch.chdir(tmp_path)
    given = str(tmp_path / "my models/mine.safetensors") if is_absolute else "my models/mine.safetensors"
    planned = dataclasses.replace(plan("random"), subject=Subject("S5", given, "none", 1))
    with Ledger(Path("found here"), planned.settings) as ledger:
        run_campaign(planned, ledger, lambda points: iter([made_up("COLLISION", "a", BEST, ()) for _ in points]), 1)
    [entry] = ledger.entries
    monkeypatch.chdir("found here")
    words = shlex.split(entry.reproduction.command)
    assert words[4:] == ["--policy", entry.reproduction.policy, "--repair", "none"]
    assert Path(words[3]).is_file()
    assert Path(words[5]).samefile(tmp_path / "my models" / "mine.safetensors")
    assert Path(words[5]).is_absolute() is is_absolute


def test_a_point_that_cannot_be_run_is_a_result():
    crashed = evaluate(Subject("S5", "modular", "none", 0), NamedPoint("one", {"lanes": 2}))
    assert (crashed.outcome, crashed.digest, crashed.fitness) == (CRASH, "", CRASH_FITNESS)
    assert "KeyError" in crashed.text


def test_the_command_says_why_points_could_not_be_run(tmp_path, capsys, monkeypatch):
    def fail(_subject, point):
        return Evaluation(None, f"KeyError: {point.name}", CRASH_FITNESS, (0.0,) * FEATURES)

    monkeypatch.setattr(command_of_search, "evaluate", fail)
    arguments = ["search", "--family", "S5", "--technique", "random", "--budget", "2", "--workers", "1"]
    for more in ([], ["--json"]):
        assert main([*arguments, "--out", str(tmp_path), *more]) == 1
        assert "2 of 2 could not be run, first: KeyError: " in capsys.readouterr().err


@pytest.mark.parametrize("names", [("S9", "modular", "none"), ("S1", "nobody", "none"), ("S1", "modular", "magic")])
def test_unknown_names_are_refused(names):
    with pytest.raises(InputError):
        Subject(*names, seed=0)


def test_the_command_refuses_other_settings_in_one_line(tmp_path, capsys):
    search(tmp_path, "random", 1)
    assert main(["search", "--family", "S4", "--technique", "random", "--seed", "1", "--out", str(tmp_path)]) == 2
    [line] = capsys.readouterr().err.splitlines()
    assert "holds work with family 'S5', not 'S4'" in line


@pytest.mark.parametrize("text", ["[]", "a: [", "batch: 0", "bacth: 3", "1: 2"])
def test_the_command_refuses_a_bad_parameter_file(tmp_path, capsys, text):
    (tmp_path / "file.yaml").write_text(text)
    arguments = ["--family", "S4", "--technique", "random", "--parameters", str(tmp_path / "file.yaml")]
    assert main(["search", *arguments, "--out", str(tmp_path / "out")]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1
    assert not (tmp_path / "out").exists()


def ego(speed):
    return EgoState.from_yaw(0.0, 0.0, 0.0, speed, 0.0, 4.0, 2.0)


def scene(ego_speed, other_x, other_speed):
    other = ObjectList.of(
        id=[1],
        kind=1,
        x=other_x,
        y=0.0,
        yaw=0.0,
        speed=other_speed,
        acceleration=0.0,
        yaw_rate=0.0,
        length=4.0,
        width=2.0,
    )
    return Scene(0.0, ego(ego_speed), other, np.empty(0, np.uint8))


@pytest.mark.parametrize(
    ("ego_speed", "other_x", "other_speed", "expected"),
    [
        (0.0, 10.0, 0.0, 6.0 + CLOSING_WEIGHT * HORIZON),  # both stand
        (10.0, 16.0, 4.0, 12.0 + CLOSING_WEIGHT * 2.0),  # 12 m at 6 m/s
        (4.0, 16.0, 10.0, 12.0 + CLOSING_WEIGHT * HORIZON),  # it drives away
        (4.0, -16.0, 10.0, 12.0 + CLOSING_WEIGHT * 2.0),  # from behind
        (0.0, 900.0, 0.0, FARTHEST + CLOSING_WEIGHT * HORIZON),
        (5.0, 1.0, 0.0, 0.0),  # touching
    ],
)
def test_danger_is_distance_and_time_to_collision(ego_speed, other_x, other_speed, expected):
    danger = Danger()
    danger.watch(scene(ego_speed, other_x, other_speed))
    assert danger.least == pytest.approx(expected)
    danger.watch(scene(0.0, 500.0, 0.0))
    assert danger.least == pytest.approx(expected)


def test_features_have_one_length_whatever_the_duration():
    for ticks in (0, 1, 2, 7, 900):
        recorder = BehaviourRecorder(0.05)
        for tick in range(ticks):
            recorder.watch(ego(15.0 * tick / max(ticks - 1, 1)))
        assert len(recorder.features()) == FEATURES
    assert recorder.features()[0] == 0.0
    assert recorder.features()[7] == 1.0  # 15 m/s at the end
