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
    assert rescue["strongest"] < 0.0
    first = rescue["triggers"][0]
    assert (first["kind"], first["place"]) == ("car", "ahead left")
    assert 0.0 < first["distance"] < 40.0
    assert 0.0 < first["bearing_degrees"] < 45.0


def test_a_run_without_interventions_has_none_to_judge(capsys):
    assert main(["bag", "need", str(SAMPLES / "collision"), "--futures", "1"]) == 0
    assert "0 interventions, 0 of them a nuisance" in capsys.readouterr().out


def test_a_run_that_does_not_repeat_itself_is_refused(tmp_path, capsys):
    for command in (["need"], ["info"], ["plot", "--out", str(tmp_path / "a.png")]):
        assert main(["bag", *command, str(SAMPLES / "faults"), "--futures", "1"]) == 2
        said = capsys.readouterr()
        assert "differs at" in said.err.splitlines()[-1]
        assert "--from-time" not in said.err, "none of these has that option"
        assert said.out == ""
    assert not list(tmp_path.iterdir())


def test_information_and_page_tell_the_need_when_they_are_asked(tmp_path, capsys):
    assert main(["bag", "info", str(SAMPLES / "repaired"), "--futures", "2"]) == 0
    table = capsys.readouterr().out.splitlines()
    head = next(place for place, line in enumerate(table) if "verdict" in line)
    assert table[head].split() == ["begins", "lasts", "dose", "strongest", "worth", "need", "verdict", "who", "why"]
    assert "1.00  rescue   car 5 ahead left, 14 m" in table[head + 1]
    page = tmp_path / "page.html"
    assert main(["bag", "plot", str(SAMPLES / "repaired"), "--futures", "2", "--out", str(page)]) == 0
    assert ">rescue</span>" in page.read_text("utf-8")


def test_a_policy_that_is_not_there_is_refused_before_the_bag_is_read(tmp_path, capsys):
    for command in (["need"], ["info"], ["plot", "--out", str(tmp_path / "a.png")]):
        assert main(["bag", *command, str(tmp_path / "none"), "--futures", "1", "--policy", "autopilot"]) == 2
        assert "there is no 'autopilot'" in capsys.readouterr().err
