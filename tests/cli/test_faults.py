"""``roadmend faults``: one disturbed run of the real graph, judged, and kept."""

import json

import pytest

from roadmend.cli import faults as command
from roadmend.cli.main import main

CAMPAIGN = """
repair: rss
families: [S3]
seeds: 1
clocks: [lockstep]
earliest: 0.5
latest: 1.0
signals:
  - {name: policy killed, node: policy, signal: KILL, declared: STALE_COMMAND, exits: [1]}
topics:
  - {name: no number, topic: policy/command, distortion: nan, declared: INVALID_COMMAND}
files: {kinds: [corpus, search settings], damages: [truncated, endless], flips: 1}
"""


@pytest.mark.graph
def test_a_killed_policy_is_safe_and_reported_and_what_was_run_is_not_run_again(tmp_path, capsys, monkeypatch):
    file = tmp_path / "campaign.yaml"
    file.write_text(CAMPAIGN)
    arguments = ["faults", "--config", str(file), "--out", str(tmp_path / "out"), "--page"]
    assert main([*arguments, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    bare, killed, distorted, *files = told["rows"]
    assert (bare["runs"], bare["safe"]) == (1, 1)
    assert killed["runs"] + told["too_late"] == 1
    assert killed["safe"] == killed["reported"] == killed["runs"]
    assert distorted["safe"] == distorted["reported"] == distorted["within_3_ticks"] == 1
    assert [(row["fault"], row["safe"]) for row in files] == [
        ("corpus: truncated", 1),
        ("corpus: endless", 1),
        ("search settings: truncated", 1),
        ("search settings: endless", 1),
    ]
    monkeypatch.setattr(command, "disturb", None)
    monkeypatch.setattr(command, "FileBench", lambda: None)
    assert main(arguments) == 0
    assert "policy killed" in capsys.readouterr().out
    for name in ("faults.md", "faults.html"):
        assert "policy killed" in (tmp_path / "out" / name).read_text()


def test_a_row_that_there_is_not_is_named_with_those_that_are(tmp_path, capsys):
    assert main(["faults", "--fault", "all", "--out", str(tmp_path / "out")]) == 2
    assert "choose of policy killed" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
