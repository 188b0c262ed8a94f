"""``roadmend sera tune`` from patterns to a tuned policy that drives."""

import json
import random

import pytest

from roadmend.cli import sera_tune
from roadmend.cli.main import main
from roadmend.core.errors import InputError
from roadmend.networks.checkpoint import find_model, load_checkpoint
from roadmend.policies.registry import make_policy
from roadmend.world.corpus import Case, Corpus, save_corpus
from roadmend.world.families import FAMILIES
from roadmend.world.point_text import used_parameters
from roadmend.world.space import sample

TINY = "{epochs: 1, replay: 1, validation: 1, every: 10, expert_drives: 1, policy_drives: 0}"
UNGUARDED = "{epochs: 1, replay: 0, keep: last, every: 10, expert_drives: 1, policy_drives: 0}"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("tune")


@pytest.fixture(scope="module")
def bank(folder):
    path = folder / "small.bank"
    assert main(["sera", "bank", "build", "--sample", "2", "--out", str(path)]) == 0
    return path


@pytest.fixture
def selection(folder, bank, capsys):
    capsys.readouterr()
    assert main(["sera", "recommend", "--bank", str(bank), "--pattern", "cut-in", "-k", "1", "--json"]) == 0
    path = folder / "selection.json"
    path.write_text(capsys.readouterr().out)
    return path


@pytest.mark.parametrize("policy", ["deep_sets"])
def test_a_selection_becomes_a_model_that_tells_where_it_comes_from(folder, bank, selection, policy, capsys):
    settings, out = folder / "tiny.yaml", folder / f"{policy}.safetensors"
    settings.write_text(TINY)
    command = ["sera", "tune", "--policy", policy, "--bank", str(bank), "--selection", str(selection)]
    command += ["--config", str(settings), "--workers", "1", "--out", str(out)]
    assert main([*command, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert [trial["epochs"] for trial in told["trials"]] == [0, 1]
    model = load_checkpoint(out, policy)
    assert model.digest == told["digest"]
    assert model.header["ancestry"][0] == load_checkpoint(find_model(policy)).digest
    assert len(model.header["configuration"]["few_shot"]["bank"]) == 64
    assert make_policy(policy, {"model": str(out)}).model_digest == model.digest
    settings.write_text(UNGUARDED)  # the same demonstrations; nothing else needs to be driven for the table
    assert main(command) == 0
    arrived = told["outcomes"].count("GOAL")
    assert f"{arrived} of {len(told['outcomes'])} demonstrations reached" in capsys.readouterr().out


def test_only_what_is_selected_is_left_out_of_the_validation_set(tmp_path, monkeypatch, capsys):
    space = FAMILIES["S4"].space
    points = [sample(space, random.Random(seed)) for seed in range(5)]
    used = [used_parameters(FAMILIES["S4"].build, point, 7) for point in points]
    cases = [
        Case(f"exit-{n}", "S4", "validation", 7, each, "GOAL", "", "random", 0, n, "", None, 9.0)
        for n, each in enumerate(used)
    ]
    corpus, bank, selection = tmp_path / "corpus.jsonl", tmp_path / "b.bank", tmp_path / "selection.json"
    save_corpus(Corpus("neural", tuple(cases)), corpus)
    assert main(["sera", "bank", "build", "--corpus", str(corpus), "--split", "validation", "--out", str(bank)]) == 0
    capsys.readouterr()
    assert main(["sera", "recommend", "--bank", str(bank), "--pattern", "an exit", "-k", "2", "--json"]) == 0
    selection.write_text(capsys.readouterr().out)
    driven = []

    def repair(*given, validation, **_):
        driven.append(({one.name for one in given[1]}, {one.name for one in validation}))
        raise InputError("tuning", "is not what is tested here", "go on")

    monkeypatch.setattr(sera_tune, "few_shot_repair", repair)
    command = ["sera", "tune", "--bank", str(bank), "--selection", str(selection), "--validation", str(corpus)]
    assert main([*command, "--out", str(tmp_path / "x.safetensors")]) == 2
    assert "is not what is tested here" in capsys.readouterr().err
    ((learned, validated),) = driven
    assert len(learned) == 2
    assert validated == {case.name for case in cases} - learned


def test_a_teachers_repair_that_there_is_not_is_one_line(folder, bank, selection, capsys):
    settings, out = folder / "nobody.yaml", folder / "nobody.safetensors"
    settings.write_text("repair: nobody")
    command = ["sera", "tune", "--bank", str(bank), "--selection", str(selection), "--config", str(settings)]
    assert main([*command, "--out", str(out)]) == 2
    assert "ships no adreft-nobody" in capsys.readouterr().err
    assert not out.exists()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"--out": "model.txt"}, "is no model file's name"),
        ({"--policy": "nobody"}, "roadmend ships no nobody"),
        ({"--selection": "gone.json"}, "gone.json"),
        ({"--bank": "gone.bank"}, "no such file"),
    ],
)
def test_mistakes_are_one_line_and_leave_nothing(folder, bank, selection, change, message, capsys):
    given = {
        "--policy": "neural",
        "--bank": str(bank),
        "--selection": str(selection),
        "--out": str(folder / "x.safetensors"),
    }
    arguments = [part for pair in {**given, **change}.items() for part in pair]
    assert main(["sera", "tune", *arguments]) == 2
    assert message in capsys.readouterr().err
    assert not (folder / "x.safetensors").exists()
