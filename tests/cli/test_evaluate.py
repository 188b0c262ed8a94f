"""``roadmend evaluate``: real episodes of two short scenarios, kept and put into a table."""

import json

import pytest

from roadmend.cli.main import main
from roadmend.core.errors import SimulationError
from roadmend.measures import evaluation
from roadmend.world.families import sample_scenario
from roadmend.world.scenario_file import save_scenario


def fail(why):
    raise SimulationError(why)


@pytest.fixture
def scenarios(tmp_path):
    folder = tmp_path / "scenarios"
    folder.mkdir()
    for seed in (0, 1):
        scenario = sample_scenario("S3", seed).model_copy(update={"time_limit": 3.0})
        save_scenario(scenario, folder / f"{seed}.yaml")
    return folder


def test_a_folder_of_scenarios_is_driven_once_with_the_trivial_methods_beside(scenarios, tmp_path, capsys, monkeypatch):
    arguments = ["evaluate", str(scenarios), "--repair", "rss", "--out", str(tmp_path / "out"), "--workers", "1"]
    assert main([*arguments, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert [*told["policies"]] == ["modular"]
    assert [*told["policies"]["modular"]] == ["none", "random", "rss"]
    assert all(each["episodes"] == 2 for each in told["policies"]["modular"].values())
    assert len(told["episodes"]) == 6
    assert json.loads((tmp_path / "out" / "evaluation.json").read_text())["episodes"] == told["episodes"]
    monkeypatch.setattr(evaluation, "run_episode", None)  # nothing is driven again
    assert main([*arguments, "--page"]) == 0
    shown = capsys.readouterr().out
    assert "modular  rss" in shown
    assert "dose [s]" in shown
    assert "ΔE" in (tmp_path / "out" / "evaluation.md").read_text()
    page = (tmp_path / "out" / "evaluation.html").read_text()
    assert all(f">{each['scenario']}<" in page for each in told["episodes"])


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["missing.yaml"], "no such file"),
        (["."], "holds no scenario"),
        (["a.yaml", "--count", "2"], "give SCENARIOS, or --corpus"),
        (["--split", "test"], "is of a corpus"),
        (["--policy", "autopilot", "--count", "1"], "there is no 'autopilot'"),
    ],
)
def test_what_cannot_be_measured_is_refused_before_anything_is_written(
    arguments, complaint, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    assert main(["evaluate", *arguments, "--out", "out"]) == 2
    assert complaint in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_two_scenarios_of_one_name_are_refused(scenarios, tmp_path, capsys):
    (scenarios / "again.yaml").write_text((scenarios / "0.yaml").read_text())
    assert main(["evaluate", str(scenarios), "--out", str(tmp_path / "out")]) == 2
    assert "has the name" in capsys.readouterr().err


def test_the_command_that_is_told_is_the_one_that_made_the_figures(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(evaluation, "run_episode", lambda *_: fail("stopped"))
    given = ["--family", "S3", "--count", "2", "--seed", "7", "--policy", "neural", "--futures", "0", "--no-tuned"]
    main(["evaluate", *given, "--repair", "rss", "--out", str(tmp_path / "out"), "--workers", "1", "--json"])
    told = json.loads(capsys.readouterr().out)["provenance"]["command"]
    assert told == (
        "./roadmend evaluate --policy neural --repair rss --family S3 --count 2 --seed 7 --futures 0 --no-tuned"
    )


def test_what_is_named_twice_is_driven_and_counted_once(tmp_path, capsys, monkeypatch):
    driven = []
    monkeypatch.setattr(evaluation, "run_episode", lambda scenario, *_: driven.append(scenario.name) or fail("stopped"))
    twice = ["--family", "S3", "--family", "S3", "--policy", "modular", "--policy", "modular"]
    words = ["evaluate", *twice, "--repair", "rss", "--count", "2", "--workers", "1", "--json"]
    main([*words, "--out", str(tmp_path / "out")])
    assert sorted(driven) == ["S3-0"] * 3 + ["S3-1"] * 3  # alone, with random repair and with the method
    assert len(json.loads(capsys.readouterr().out)["faults"]) == 6
