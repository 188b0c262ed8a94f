"""``roadmend train reader``: a model file comes out, the same one again, and mistakes are told in a line."""

import json

import pytest

from roadmend.cli.main import main
from roadmend.networks.checkpoint import load_checkpoint
from tests.networks.small_bert import write_bert
from tests.safe.trained.told import write_told

SETTINGS = "made_up: 8\nbeside: 0\nepochs: 1\nbatch: 4\npieces: 100\nheld_out: [bob]\n"


@pytest.fixture
def words(tmp_path):
    write_bert(tmp_path / "bert")
    told = write_told(tmp_path / "told.jsonl")
    (tmp_path / "mine.yaml").write_text(SETTINGS)
    given = ["--encoder", str(tmp_path / "bert"), "--config", str(tmp_path / "mine.yaml"), "--workers", "1"]
    return ["train", "reader", str(told), *given, "--threads", "1"]


def test_it_writes_a_model_that_says_how_it_was_made(words, tmp_path, capsys):
    out = tmp_path / "reader.safetensors"
    assert main([*words, "--out", str(out), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["lessons"], found["held_out"]) == (3, 3)
    header = load_checkpoint(out, "crash_text").header
    assert header["configuration"]["epochs"] == 1
    assert len(header["ancestry"][0]) == len(header["data_digest"]) == 64
    assert header["command"].startswith("./roadmend train reader told.jsonl --encoder bert")
    assert (tmp_path / "reader.training").is_dir()
    first = load_checkpoint(out).tensors
    again = tmp_path / "again.safetensors"
    assert main([*words, "--out", str(again)]) == 0
    assert "3 lessons; right on 3 texts held out: heading" in capsys.readouterr().out
    assert all((load_checkpoint(again).tensors[name] == value).all() for name, value in first.items())


def test_mistakes_are_told_in_a_line(words, tmp_path, capsys):
    out = ["--out", str(tmp_path / "reader.safetensors")]
    (tmp_path / "bert" / "config.json").unlink()
    assert main([*words, *out]) == 2
    assert "config.json" in capsys.readouterr().err
    (tmp_path / "told.jsonl").write_text("{}\n")
    assert main([*words, *out]) == 2
    assert "told.jsonl, line 1: is no told crash" in capsys.readouterr().err
    (tmp_path / "mine.yaml").write_text("epochs: many\n")
    assert main([*words, *out]) == 2
    assert "epochs" in capsys.readouterr().err
    assert not (tmp_path / "reader.safetensors").exists()
