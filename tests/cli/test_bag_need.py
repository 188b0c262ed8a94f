import json
from pathlib import Path

from roadmend.cli.main import main

SAMPLES = Path(__file__).parents[2] / "bags" / "samples"


def test_the_sample_shows_a_rescue(capsys):
    assert main(["bag", "need", str(SAMPLES / "repaired"), "--futures", "6", "--json"]) == 0
    spells = json.loads(capsys.readouterr().out)["spells"]
    assert [round(spell["begin"], 2) for spell in spells] == sorted(round(spell["begin"], 2) for spell in spells)
    rescue = next(spell for spell in spells if spell["verdict"] == "rescue")
    assert rescue["need"] >= 0.8
    assert rescue["reason"].startswith("criticality")
    assert rescue["objects"]


def test_a_run_without_interventions_has_none_to_judge(capsys):
    assert main(["bag", "need", str(SAMPLES / "collision"), "--futures", "1"]) == 0
    assert "0 interventions, 0 of them needless" in capsys.readouterr().out


def test_a_run_that_does_not_repeat_itself_is_refused(capsys):
    assert main(["bag", "need", str(SAMPLES / "faults"), "--futures", "1"]) == 2
    assert "differs at" in capsys.readouterr().err
