"""``roadmend sera analyse`` and ``recommend`` with a language model: kept, replayed, counted, refused."""

import json
from pathlib import Path

import pytest

from roadmend.cli.main import main

from ..language.server import serving, texts  # noqa: TID252 - one server for all rooms
from ..sera.speaking import KEY, as_completion  # noqa: TID252 - likewise

SAMPLES = Path(__file__).parents[2] / "bags" / "samples"


@pytest.fixture
def endpoint(monkeypatch):
    """Sets the environment to a server that answers each request with the next answer."""

    def use(url):
        monkeypatch.setenv("OPENAI_BASE_URL", url)
        monkeypatch.setenv("OPENAI_API_KEY", KEY)

    return use


def analysis(body):
    (one,) = json.loads(texts(body)[2])["incidents"]
    pattern = {
        "name": "exit",
        "words": "A truck cuts in at the exit.",
        "what": "COLLISION",
        "where": dict.fromkeys(one["where"]) | {"road": one["where"]["road"]},
        "who": one["who"],
        "why": one["why"],
        "evidence": [1],
    }
    return as_completion({"analysis": "...", "patterns": [pattern]})


def test_an_analysis_is_kept_counted_and_replayed(tmp_path, capsys, endpoint, monkeypatch):
    command = ["sera", "analyse", str(SAMPLES / "collision"), "--workers", "1", "--json"]
    out = tmp_path / "patterns.json"
    with serving(analysis) as (_, url):
        endpoint(url)
        assert main([*command, "--backend", "openai", "--out", str(out)]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["patterns"][0]["words"] == "A truck cuts in at the exit."
    (used,) = told["usage"].values()
    assert used == {"answers": 1, "input_tokens": 1000, "output_tokens": 50, "cost": None}
    kept = out.with_suffix(".exchanges.jsonl")
    assert KEY not in kept.read_text(encoding="utf-8")
    monkeypatch.delenv("OPENAI_API_KEY")
    again = tmp_path / "again.json"
    assert main([*command, "--backend", "replay", "--recording", str(kept), "--out", str(again)]) == 0
    assert again.read_text(encoding="utf-8") == out.read_text(encoding="utf-8")


def test_a_model_that_invents_is_one_line_and_leaves_the_exchanges_alone(tmp_path, capsys, endpoint):
    out = tmp_path / "patterns.json"
    with serving(as_completion({"analysis": "...", "patterns": []})) as (_, url):
        endpoint(url)
        command = ["sera", "analyse", str(SAMPLES / "collision"), "--backend", "openai", "--attempts", "2"]
        assert main([*command, "--out", str(out), "--workers", "1"]) == 1
    (line,) = [line for line in capsys.readouterr().err.splitlines() if line.startswith("roadmend:")]
    assert "2 answers for the failure patterns were rejected" in line
    assert [path.name for path in tmp_path.iterdir()] == ["patterns.exchanges.jsonl"]


def test_what_was_paid_for_outlives_a_call_that_fails(tmp_path, capsys, endpoint):
    out = tmp_path / "patterns.json"
    kept = out.with_suffix(".exchanges.jsonl")
    command = ["sera", "analyse", str(SAMPLES / "collision"), "--workers", "1", "--attempts", "1", "--out", str(out)]
    with serving(analysis) as (_, url):
        endpoint(url)
        assert main([*command, "--backend", "openai"]) == 0
    paid = kept.read_text(encoding="utf-8")
    with serving(as_completion({"analysis": "...", "patterns": []})) as (_, url):
        endpoint(url)
        assert main([*command, "--backend", "openai"]) == 1
    both = kept.read_text(encoding="utf-8")
    assert both.startswith(paid)
    assert len(both.splitlines()) == 2
    other = [*command[:2], str(SAMPLES / "repaired"), *command[3:]]  # the recording has no answer for it
    assert main([*other, "--backend", "replay", "--recording", str(kept)]) == 1
    assert kept.read_text(encoding="utf-8") == both
    capsys.readouterr()


@pytest.mark.parametrize(
    "command", [["analyse", str(SAMPLES / "collision")], ["recommend", "--bank", "b", "--pattern", "rain"]]
)
def test_what_a_backend_lacks_is_one_line_and_code_2(command, capsys, monkeypatch, endpoint):
    monkeypatch.delenv("OPENAI_API_KEY", raising=False)
    assert main(["sera", *command, "--backend", "openai"]) == 2
    assert "OPENAI_API_KEY: is not set" in capsys.readouterr().err
    assert main(["sera", *command, "--backend", "replay"]) == 2
    assert "backend replay: has no recording" in capsys.readouterr().err
    endpoint("http://127.0.0.1:9/v1")
    assert main(["sera", *command, "--backend", "openai"]) == 2
    assert "has no place for what is said; name a file with --out" in capsys.readouterr().err


def test_a_reflection_by_a_model(tmp_path, capsys, endpoint):
    bank, out = str(tmp_path / "b.bank"), tmp_path / "chosen.json"
    assert main(["sera", "bank", "build", "--sample", "2", "--out", bank]) == 0
    capsys.readouterr()

    def swap(body):
        data = json.loads(texts(body)[2])
        one = {"out": data["selected"][0]["number"], "into": data["others"][0]["number"], "reason": "It is wetter."}
        return as_completion({"analysis": "...", "swaps": [one]})

    with serving(swap) as (_, url):
        endpoint(url)
        command = ["sera", "recommend", "--bank", bank, "--pattern", "cut-in in rain", "-k", "2"]
        assert main([*command, "--backend", "openai", "--out", str(out)]) == 0
    printed = capsys.readouterr().out
    assert "It is wetter." in printed
    assert ": 1 answers, 1,000 tokens in, 50 out" in printed
    assert json.loads(out.read_text(encoding="utf-8"))["swaps"][0]["reason"] == "It is wetter."
    assert out.with_suffix(".exchanges.jsonl").is_file()
