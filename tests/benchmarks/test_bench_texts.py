"""``roadmend bench texts``: sets apart, beside the usual values, and a reading that is wrong counts as wrong."""

import json
from pathlib import Path

import pytest

from bench import main
from harness.bench_texts import _held_out
from harness.scoring import ORACLE, load_oracles

TEXTS = Path(__file__).parent / "crash_texts"


@pytest.fixture
def folder(tmp_path):
    """One text that is read right as two sets, in the second with an oracle that says something else."""
    there = tmp_path / "texts"
    there.mkdir()
    text = (TEXTS / "developed-01.txt").read_text()
    oracle = json.loads((TEXTS / "developed-01.oracle.json").read_text())
    other = oracle | {"num_lanes": 7, "alternatives": {}, "env": {**oracle["env"], "time": None}}
    for name, right in (("one-1", oracle), ("two-1", other)):
        (there / f"{name}.txt").write_text(text)
        (there / f"{name}.oracle.json").write_text(json.dumps(right))
    return there


def test_sets_are_scored_apart(folder, tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    assert main(["texts", str(folder), "--out", str(tmp_path), "--json", "--workers", "1"]) == 0
    content = json.loads((tmp_path / "texts.json").read_text())
    assert json.loads(capsys.readouterr().out) == content
    one, two = content["sets"]["one"], content["sets"]["two"]
    assert (one["cases"], one["overall"], two["overall"], two["road"], two["actors"]) == (1, 100.0, 0.0, 0.0, 100.0)
    assert (one["without_trained_reader"]["cases"], two["without_trained_reader"]["overall"]) == (1, 0.0)
    assert one["left_open"]["filled"] == 0
    assert (two["left_open"]["fields"], two["left_open"]["filled"]) == (one["left_open"]["fields"] + 1, 1)
    assert {"one", "two"} <= {*(tmp_path / "texts.md").read_text().split()}


def test_the_texts_held_out_are_those_of_authors_that_the_model_did_not_learn_from(tmp_path):
    folder = _held_out(tmp_path / "held_out")
    authors = {"mixed-1", "adjusters-1", "claims-3", "chats-4"}
    oracles = load_oracles(folder)
    assert len(oracles) == len([*folder.glob("*.txt")]) == 240
    assert {name.removeprefix("held_out-").rpartition("-")[0] for name in oracles} == authors


def test_of_texts_that_an_earlier_model_was_measured_on_none_is_left(tmp_path):
    (tmp_path / "held_out").mkdir()
    for name in ("held_out-bob-1.txt", f"held_out-bob-1.{ORACLE}"):
        (tmp_path / "held_out" / name).write_text("{}")
    assert not any("bob" in name for name in load_oracles(_held_out(tmp_path / "held_out")))


def test_a_folder_without_oracles_is_refused(tmp_path, capsys):
    assert main(["texts", str(tmp_path)]) == 2
    assert "holds no text with an oracle" in capsys.readouterr().err
