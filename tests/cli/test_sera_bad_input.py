"""Files that are no good, at the command line: one clear line, or an honest empty result."""

import json
import shutil
import sqlite3
from pathlib import Path

import pytest

from roadmend.cli.main import main
from roadmend.sera.bank import build_bank
from roadmend.sera.describe import entry_of
from roadmend.sera.evaluation_episode import EvaluationJob, evaluate
from roadmend.world.families import sample_scenario

SAMPLES = Path(__file__).parents[2] / "bags" / "samples"
WORDS = ["--pattern", "a truck cuts in at a highway exit"]


@pytest.fixture
def bank(tmp_path):
    path = tmp_path / "some.bank"
    build_bank(path, [entry_of(sample_scenario("S4", seed), "test") for seed in range(3)])
    return path


def commands(bank, tmp_path):
    """Everything that reads a bank."""
    return [
        ["bank", "show", "--bank", str(bank)],
        ["bank", "search", "--bank", str(bank), *WORDS],
        ["bank", "export", "--bank", str(bank), "--out", str(tmp_path / "new")],
        ["recommend", "--bank", str(bank), *WORDS],
        ["evaluate", "--disjoint-from", str(bank), "--out", str(tmp_path / "new")],
        ["cycle", "--bank", str(bank), "--bags", str(SAMPLES), "--out", str(tmp_path / "new")],
    ]


def test_a_bank_of_another_version_is_one_line_everywhere_and_leaves_nothing(bank, tmp_path, capsys):
    with sqlite3.connect(bank) as connection:
        connection.execute("UPDATE meta SET value = 'roadmend-bank/9' WHERE key = 'format'")
    connection.close()
    for command in commands(bank, tmp_path):
        assert main(["sera", *command]) == 2
        (line,) = capsys.readouterr().err.strip().splitlines()
        assert "has the format 'roadmend-bank/9', not 'roadmend-bank/1'; export it with" in line
    assert [path.name for path in tmp_path.iterdir()] == ["some.bank"]


def test_a_cycle_from_a_bank_of_another_embedder_leaves_nothing(bank, tmp_path, capsys):
    command = ["cycle", "--bank", str(bank), "--embedder", "openai:other", "--out", str(tmp_path / "new")]
    assert main(["sera", *command]) == 2
    assert "embedder" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["some.bank"]


def test_a_bank_cut_short_is_one_line_everywhere(bank, tmp_path, capsys):
    bank.write_bytes(bank.read_bytes()[: bank.stat().st_size // 2])
    for command in commands(bank, tmp_path):
        assert main(["sera", *command]) == 2
        (line,) = capsys.readouterr().err.strip().splitlines()
        assert "damaged" in line


def test_an_empty_bank_is_an_honest_empty_result(tmp_path, capsys):
    bank = tmp_path / "empty.bank"
    build_bank(bank, [])
    assert main(["sera", "bank", "show", "--bank", str(bank)]) == 0
    assert "0 scenarios" in capsys.readouterr().out
    assert main(["sera", "bank", "search", "--bank", str(bank), *WORDS]) == 0
    assert "nothing fits: the bank is empty" in capsys.readouterr().out
    assert main(["sera", "recommend", "--bank", str(bank), *WORDS, "-k", "3"]) == 0
    assert "3 places stay empty" in capsys.readouterr().out
    assert main(["sera", "recommend", "--bank", str(bank), *WORDS, "-k", "3", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["refined"] == []


def test_a_bank_of_nothing_does_not_replace_one(bank, capsys):
    before = bank.read_bytes()
    assert main(["sera", "bank", "build", "--out", str(bank)]) == 2
    assert main(["sera", "analyse", str(SAMPLES), "--out", str(bank)]) == 2
    assert bank.read_bytes() == before
    assert "holds no patterns" in capsys.readouterr().err


def test_a_selection_takes_the_place_of_a_selection_alone(bank, tmp_path, capsys):
    before, text, out = bank.read_bytes(), tmp_path / "text.json", tmp_path / "selection.json"
    text.write_text('["mine"]', encoding="utf-8")
    for path in (bank, text):
        assert main(["sera", "recommend", "--bank", str(bank), *WORDS, "--out", str(path)]) == 2
        assert f"{path}: is there already and holds no selection" in capsys.readouterr().err
    assert (bank.read_bytes(), text.read_text(encoding="utf-8")) == (before, '["mine"]')
    for count in ("1", "2"):
        assert main(["sera", "recommend", "--bank", str(bank), *WORDS, "-k", count, "--out", str(out)]) == 0
    assert len(json.loads(out.read_text(encoding="utf-8"))["refined"]) == 2


@pytest.fixture(scope="module")
def success(tmp_path_factory):
    """A bag in which nothing goes wrong."""
    folder = tmp_path_factory.mktemp("bags")
    episode = evaluate(EvaluationJob(sample_scenario("S4", 4), "modular", "none", folder, "all", "test"))
    assert (episode.fault, episode.measures.outcome) == ("", "GOAL")
    return folder / episode.bag


def test_bags_without_failures_are_an_honest_empty_result(success, tmp_path, capsys):
    out = tmp_path / "patterns.json"
    assert main(["sera", "analyse", str(success), "--workers", "1", "--out", str(out)]) == 0
    assert "No failure and no intervention in these bags." in capsys.readouterr().out
    assert json.loads(out.read_text(encoding="utf-8")) == []
    assert "1 bag read, 0 incidents, 0 patterns" in out.with_suffix(".md").read_text(encoding="utf-8")
    assert main(["sera", "recommend", "--bank", "some.bank", "--pattern", str(out)]) == 2
    assert "holds no pattern" in capsys.readouterr().err


def test_corrupt_bags_alone_are_named_and_the_code_is_1(tmp_path, capsys):
    shutil.copytree(SAMPLES / "collision", tmp_path / "torn")
    (file,) = (tmp_path / "torn").glob("*.mcap")
    file.write_bytes(b"no MCAP" * 100)
    assert main(["sera", "analyse", str(tmp_path), "--workers", "1"]) == 1
    printed = capsys.readouterr()
    assert "No bag could be read." in printed.out
    assert f"not read: {file}" in printed.err
    assert "Traceback" not in printed.err
