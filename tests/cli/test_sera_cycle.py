"""``roadmend sera cycle`` from the sample bags by one command; the tuning alone is acted, since it needs torch."""

import json
import shutil
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest
from PIL import Image

from roadmend.cli import sera_cycle
from roadmend.cli.main import main
from roadmend.networks.checkpoint import find_model
from roadmend.training.adreft.adjusting import adjust

SAMPLES = Path(__file__).parents[2] / "bags" / "samples"
QUICK = [
    "--generations",
    "1",
    "--scenarios",
    "1",
    "--first-seed",
    "4",
    "--bank-scenarios",
    "4",
    "-k",
    "2",
    "--workers",
    "1",
]


@pytest.fixture
def lessons(monkeypatch):
    """What the tuning was given, instead of tuning; the policy stays as it was."""
    given = []

    def few_shot_repair(model, scenarios, settings, seed, out, **others):
        given.append((model, [*scenarios], settings, seed, others))
        others["labour"].report("learning", 1, 1)
        shutil.copy(model, out)
        trial = SimpleNamespace(epochs=0, driving_score=60.0)
        return SimpleNamespace(kept=trial, trials=(trial,))

    repair, device = ModuleType("roadmend.training.few_shot"), ModuleType("roadmend.training.device")
    repair.few_shot_repair, repair.TuningOrigin = few_shot_repair, lambda *values: values
    repair.Labour = lambda workers, report: SimpleNamespace(workers=workers, report=report)
    device.choose_torch_device = lambda *_: None
    for module in (repair, device):
        monkeypatch.setitem(sys.modules, module.__name__, module)
    return given


def test_the_cycle_end_to_end_from_the_sample_bags_and_once_more(tmp_path, capsys, lessons):
    out, teacher, settings_file = tmp_path / "cycle", tmp_path / "teacher.safetensors", tmp_path / "few-shot.yaml"
    shutil.copy(find_model("precaution-modular", "adreft-"), teacher)
    settings_file.write_text(f"repair: {teacher}\n", encoding="utf-8")
    command = ["sera", "cycle", "--bags", str(SAMPLES / "collision"), "--out", str(out), "--epochs", "2", *QUICK]
    command += ["--config", str(settings_file)]
    assert main([*command, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert json.loads((out / "cycle.json").read_text(encoding="utf-8")) == told
    assert told["provenance"]["command"].startswith(
        f"./roadmend sera cycle --policy neural --bags {SAMPLES / 'collision'}"
    )
    assert f" --config {settings_file} --epochs 2" in told["provenance"]["command"]
    first, last = told["generations"]
    assert first["patterns"] == ["collision in the exit lane: the ego drives on, a car cuts in"]
    assert len(first["selected"]) == 2
    assert first["tuned"] == {
        "model": "generation-0/model.safetensors",
        "epochs": 0,
        "driving_score": 60.0,
        "before": 60.0,
    }
    assert first["summary"]["episodes"] == 5
    assert last["summary"] == first["summary"]
    assert last["tuned"] is None
    assert Image.open(out / "cycle.png").size[0] > 1000
    assert "Generation 1" in (out / "cycle.html").read_text(encoding="utf-8")

    (given,) = lessons
    model, scenarios, settings, seed, others = given
    assert (model.name, settings.epochs, seed, len(scenarios)) == ("neural.safetensors", 2, 0, 2)
    assert [scenario.name for scenario in scenarios] == first["selected"]
    assert others["labour"].workers == 1

    (out / "cycle.jsonl").unlink()  # as of a cycle before folders were marked
    assert main(command) == 0
    printed = capsys.readouterr().out
    assert "generation 0: 1 incidents, 1 patterns, 2 scenarios" in printed
    assert "no epoch was better than the policy as it was" in printed
    assert len(lessons) == 1  # nothing is done twice

    adjust(teacher, teacher, 0.6, {}, "")
    assert main(command) == 0
    assert len(lessons) == 2  # another teacher under the same name, from the same scenarios
    assert lessons[1][1] == scenarios


def test_a_folder_of_somebody_elses_or_of_another_process_is_left_alone(tmp_path, capsys):
    theirs, busy = tmp_path / "theirs", tmp_path / "busy"
    theirs.mkdir()
    (theirs / "cycle.json").write_text("mine", encoding="utf-8")
    assert main(["sera", "cycle", "--out", str(theirs), *QUICK]) == 2
    assert "is not empty and holds no cycle.jsonl" in capsys.readouterr().err
    assert [path.read_text(encoding="utf-8") for path in theirs.iterdir()] == ["mine"]
    with sera_cycle._claimed(busy):
        assert main(["sera", "cycle", "--out", str(busy), *QUICK]) == 2
    assert "another process is at work here" in capsys.readouterr().err
    assert [path.name for path in busy.iterdir()] == ["cycle.jsonl"]


def test_a_bank_of_other_families_or_other_code_is_built_anew(tmp_path, monkeypatch):
    monkeypatch.setattr(sera_cycle, "build_bank", lambda path, _entries, report: path.write_text(report.__name__))
    first = sera_cycle._built_bank(tmp_path, 4, lambda *_: None)
    assert first.is_file()
    assert sera_cycle._built_bank(tmp_path, 4, lambda *_: None) == first
    assert sera_cycle._built_bank(tmp_path, 5, lambda *_: None) != first
    with monkeypatch.context() as other:
        other.setattr(sera_cycle, "FAMILIES", ["S1"])
        assert sera_cycle._built_bank(tmp_path, 4, lambda *_: None) != first
    monkeypatch.setattr("roadmend.core.journal.source_digest", lambda _: "other code")
    assert sera_cycle._built_bank(tmp_path, 4, lambda *_: None) != first


def test_a_teacher_that_there_is_not_is_refused_before_anything_is_driven(tmp_path, capsys):
    file = tmp_path / "few-shot.yaml"
    file.write_text("repair: nobody\n", encoding="utf-8")
    assert main(["sera", "cycle", "--out", str(tmp_path / "out"), "--config", str(file)]) == 2
    assert "roadmend ships no adreft-nobody.safetensors" in capsys.readouterr().err
    assert [*tmp_path.iterdir()] == [file]


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["--policy", "modular"], "roadmend ships no modular.safetensors"),
        (["--policy", "nowhere.safetensors"], "no such model file"),
        (["--bags", "nowhere"], "there is no such bag or folder"),
        (["--config", "nowhere.yaml"], "nowhere.yaml"),
        (["--backend", "replay"], "has no recording"),
    ],
)
def test_what_cannot_work_is_one_line_and_leaves_nothing(tmp_path, capsys, arguments, complaint):
    assert main(["sera", "cycle", "--out", str(tmp_path / "out"), *arguments]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert complaint in line
    assert not list(tmp_path.iterdir())
