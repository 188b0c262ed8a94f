"""``roadmend train``: the command that a model tells makes it again."""

from types import SimpleNamespace

import pytest

from roadmend.cli import train, train_monitors
from roadmend.cli.main import main
from roadmend.core.resources import config_folder
from roadmend.networks.checkpoint import find_model, load_checkpoint

SHIPPED = find_model("modular", "adreft-")


@pytest.fixture
def made(tmp_path, monkeypatch):
    """Commands that would go into headers; nothing is trained."""
    told = []

    def training(*given):
        told.append(given[-2])
        return SimpleNamespace(run=lambda: SHIPPED)

    def monitor(*_given, command, **_named):
        told.append(command)
        raise KeyboardInterrupt

    monkeypatch.setattr(train, "Training", training)
    monkeypatch.setattr(train_monitors, "train_risk_monitor", monitor)
    monkeypatch.chdir(tmp_path)
    return told


def test_a_policy_tells_its_settings_and_where_it_was_trained(made, tmp_path):
    settings = tmp_path / "mine.yaml"
    settings.write_text((config_folder() / "training" / "policy-neural.yaml").read_text())
    words = ["--config", str(settings), "--rounds", "1", "--device", "cpu", "--workers", "3"]
    assert main(["train", "policy", *words, "--out", str(tmp_path / "a.safetensors")]) == 0
    (tmp_path / "b.rounds").mkdir()
    assert main(["train", "policy", *words, "--resume", "--out", str(tmp_path / "b.safetensors")]) == 0
    told = "./roadmend train policy --kind neural --seed 0 --config mine.yaml --rounds 1 --device cpu"
    assert made == [told, told]  # an interruption makes no other model


@pytest.mark.parametrize("kind", ["need", "changes"])
def test_a_monitor_tells_corpus_and_seed(kind, made, tmp_path):
    corpus = tmp_path / "mine.jsonl"
    corpus.write_bytes((config_folder() / "corpora" / "modular.jsonl").read_bytes())
    words = [str(SHIPPED), "--corpus", str(corpus), "--also", "neural", "--set", "epochs=3", "--seed", "7"]
    assert main(["train", kind, *words, "--work", "w", "--workers", "1", "--out", "m.safetensors"]) == 130
    told = "--policy modular --corpus mine.jsonl --also neural --set epochs=3 --seed 7"
    assert made == [f"./roadmend train {kind} {SHIPPED.name} {told}"]


def test_a_model_that_was_adjusted_tells_its_threshold_to_the_last_digit(tmp_path):
    out = tmp_path / "out.safetensors"
    words = ["--threshold", "0.123456789", "--set", "longest=8.0"]
    assert main(["train", "adjust", str(SHIPPED), *words, "--out", str(out)]) == 0
    told = f"./roadmend train adjust {SHIPPED.name} --threshold 0.123456789 --set longest=8.0"
    assert load_checkpoint(out).header["adjusted"]["command"] == told
