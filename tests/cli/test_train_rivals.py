"""``roadmend train self-oracle`` and ``roadmend train rivals`` on a corpus of a few random draws."""

import json
import random
from dataclasses import replace

import pytest
import yaml

from roadmend.cli import train_rivals
from roadmend.cli.main import main
from roadmend.networks.checkpoint import load_checkpoint
from roadmend.policies.registry import make_policy
from roadmend.repair.registry import make_repairer
from roadmend.training.tuning_grid import rivals_of
from roadmend.world.corpus import Case, Corpus, save_corpus
from roadmend.world.families import FAMILIES
from roadmend.world.runner import run_episode
from roadmend.world.space import sample


def case_of(number, split, outcome):
    family = FAMILIES["S4"]
    parameters = sample(family.space, random.Random(number))
    scenario = family.build(parameters, f"case-{number}", number)
    summary = run_episode(scenario, make_policy("modular"), make_repairer("none"))
    return Case(
        name=scenario.name,
        family="S4",
        split=split,
        seed=number,
        parameters=parameters,
        outcome=outcome,
        digest=summary.digest,
        technique="random",
        search_seed=0,
        index=number,
        text=summary.text,
        min_distance=1.0,
        duration=summary.duration,
    )


@pytest.fixture(scope="module")
def corpus(tmp_path_factory):
    """Successes for training; for validation a success, and one that is said to be a violation."""
    wanted = [("training", "GOAL"), ("training", "GOAL"), ("validation", "GOAL"), ("validation", "COLLISION")]
    cases = [case_of(number, split, outcome) for number, (split, outcome) in enumerate(wanted)]
    path = tmp_path_factory.mktemp("corpus") / "modular.jsonl"
    save_corpus(Corpus("modular", tuple(cases)), path)
    return path


def test_the_autoencoder_and_the_settings_are_written(corpus, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(
        train_rivals, "rivals_of", lambda model: [replace(one, grid=one.grid[:2]) for one in rivals_of(model)]
    )
    model, again, out = tmp_path / "oracle.safetensors", tmp_path / "2" / "oracle.safetensors", tmp_path / "tuned.yaml"
    base = ["train", "self-oracle", "--corpus", str(corpus), "--epochs", "2", "--workers", "1"]
    assert main([*base, "--out", str(model)]) == 0
    assert "held-out frames" in capsys.readouterr().out
    assert main([*base, "--out", str(again), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["model"] == str(again)
    assert model.read_bytes() == again.read_bytes()
    told = "./roadmend train self-oracle --policy modular --corpus modular.jsonl --seed 0 --epochs 2"
    assert load_checkpoint(model).header["configuration"]["command"] == told

    base = ["train", "rivals", "--corpus", str(corpus), "--out", str(out), "--workers", "1"]
    assert main([*base, "--only", "random"]) == 0
    first = yaml.safe_load(out.read_text())
    assert list(first["methods"]) == ["random"]
    assert first["cases"] == 2
    capsys.readouterr()
    assert main([*base, "--only", "model", "--model", str(model), "--json"]) == 0
    both = yaml.safe_load(out.read_text())
    assert [*json.loads(capsys.readouterr().out)["rivals"]] == [*both["methods"]]
    assert list(both["methods"]) == ["random", "model"]
    assert both["methods"]["random"] == first["methods"]["random"]
    assert both["methods"]["model"]["parameters"]["model"] == "modular"
    assert len(both["methods"]["model"]["grid"]) == 2
    told = "./roadmend train rivals --policy modular --corpus modular.jsonl"
    assert {name: each["command"] for name, each in both["methods"].items()} == {
        "random": f"{told} --only random",
        "model": f"{told} --only model --model oracle.safetensors",
    }


@pytest.mark.parametrize("command", ["self-oracle", "rivals"])
def test_a_missing_corpus_is_one_line_and_code_2(command, tmp_path, capsys):
    arguments = ["train", command, "--corpus", str(tmp_path / "no.jsonl"), "--out", str(tmp_path / "out")]
    assert main(arguments) == 2
    assert capsys.readouterr().err.count("\n") == 1
