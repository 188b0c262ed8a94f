"""``roadmend networks``, and ``roadmend evaluate --sumocfg`` on what it makes."""

import json

import pytest

from roadmend.cli.main import main
from roadmend.measures import evaluation


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("networks")
    arguments = ["networks", "--kind", "ring", "--kind", "rural", "--count", "1", "--seed", "7"]
    assert main([*arguments, "--out", str(folder), "--workers", "1"]) == 0
    return folder


def test_every_configuration_is_a_folder_of_three_files(made):
    assert sorted(str(path.relative_to(made)) for path in made.rglob("*.*")) == [
        f"{name}/{name}.{ending}" for name in ("ring-7", "rural-7") for ending in ("net.xml", "rou.xml", "sumocfg")
    ]


def test_drives_on_a_folder_are_measured_and_kept(made, tmp_path, capsys, monkeypatch):
    arguments = ["evaluate", "--sumocfg", str(made), "--count", "2", "--time-limit", "4", "--warm-up", "30"]
    arguments += ["--repair", "rss", "--out", str(tmp_path / "out"), "--workers", "1", "--json"]
    assert main(arguments) == 0
    told = json.loads(capsys.readouterr().out)
    assert len(told["episodes"]) == 2 * 2 * 3
    assert told["faults"] == []
    assert all(each["episodes"] == 4 for each in told["policies"]["modular"].values())
    monkeypatch.setattr(evaluation, "run_episode", None)  # nothing is driven again
    assert main(arguments) == 0


def test_a_configuration_that_cannot_run_is_named_and_the_others_are_driven(made, tmp_path, capsys):
    broken = tmp_path / "broken" / "town.sumocfg"
    broken.parent.mkdir()
    broken.write_text((made / "ring-7" / "ring-7.sumocfg").read_text().replace('"ring-7', f'"{made}/ring-7/ring-7'))
    broken.write_text(broken.read_text().replace("<time>", '<leap value="1"/><time>'))
    arguments = ["evaluate", "--sumocfg", str(broken), "--sumocfg", str(made / "rural-7"), "--count", "1"]
    arguments += ["--time-limit", "1", "--warm-up", "30", "--repair", "none", "--out", str(tmp_path / "out")]
    assert main([*arguments, "--workers", "1"]) == 1
    said = capsys.readouterr().err
    assert f"InputError: {broken}: SUMO refuses it" in said
    assert "rural" not in said
    arguments = [
        "evaluate",
        "--sumocfg",
        str(broken),
        "--egos",
        "1",
        "--repair",
        "none",
        "--out",
        str(tmp_path / "none"),
    ]
    assert main([*arguments, "--workers", "1"]) == 2  # nothing was driven


def test_egos_on_a_network_alone_have_a_table_of_their_own(made, tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("ROADMEND_CACHE", str(tmp_path / "cache"))
    arguments = ["evaluate", "--net", str(made / "ring-7" / "ring-7.net.xml"), "--egos", "2", "--seed", "5"]
    arguments += ["--time-limit", "30", "--warm-up", "30", "--repair", "rss", "--out", str(tmp_path / "out")]
    assert main([*arguments, "--workers", "1", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert {each["scenario"] for each in told["episodes"]} == {"ring-7-5", "ring-7-6"}
    figures = {method: each["network"] for method, each in told["policies"]["modular"].items()}
    assert figures["none"]["interventions_per_km"] == 0.0
    assert 0.05 < figures["rss"]["kilometres"] < 2.0
    monkeypatch.setattr(evaluation, "run_episode", None)  # nothing is driven again
    assert main(arguments) == 0
    shown = capsys.readouterr().out.partition("Over the network:\n")[2]
    assert shown.splitlines()[0].split("  ")[0] == "policy"
    assert "driven [km]" in shown
    assert "time lost [s/km]" in (tmp_path / "out" / "evaluation.md").read_text()


def test_scenarios_have_no_table_over_a_network(tmp_path, capsys):
    arguments = ["evaluate", "--family", "S3", "--count", "1", "--repair", "none", "--workers", "1"]
    assert main([*arguments, "--out", str(tmp_path / "out")]) == 0
    assert "Over the network" not in capsys.readouterr().out
    assert "[s/km]" not in (tmp_path / "out" / "evaluation.md").read_text()


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["evaluate", "--sumocfg", "none.sumocfg"], "none.sumocfg: no such file"),
        (["evaluate", "--sumocfg", "."], "holds no .sumocfg; 'roadmend networks' makes some"),
        (["evaluate", "--sumocfg", ".", "--family", "S1"], "give --family or --sumocfg"),
        (["evaluate", "--sumocfg", ".", "a.yaml"], "give SCENARIOS, or --corpus"),
        (["evaluate", "--egos", "9"], "--egos: is of SUMO configurations"),
        (["evaluate", "--sumocfg", ".", "--egos", "9", "--count", "9"], "give --egos or --count"),
        (["evaluate", "--time-limit", "9"], "--time-limit: is of SUMO configurations"),
        (["evaluate", "--family", "S1", "--warm-up", "9"], "--warm-up: is of SUMO configurations"),
        (["networks", "--seed", "9999", "--count", "2"], "stay below 10000 or begin there"),
        (["networks", "--kind", "alpine"], "'alpine' is not one of"),
    ],
)
def test_what_cannot_be_is_refused_in_a_line(arguments, complaint, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main([*arguments, "--out", "out"]) == 2
    said = capsys.readouterr().err
    assert complaint in said
    assert said.count("\n") == 1
    assert not (tmp_path / "out").exists()
