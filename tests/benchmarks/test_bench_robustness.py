import json

import pytest

from bench import main
from harness import bench_robustness
from roadmend.search.evaluation import parameters_digest
from tests.search.toy import made_up


def toy(subject, point, repair=None):
    """Every point whose digest begins with a small digit collides."""
    assert not repair
    digest = parameters_digest(point.parameters)
    outcome = "COLLISION" if digest[0] in "0123" else "GOAL"
    return made_up(outcome, digest, 0.0 if outcome == "COLLISION" else -5.0, (0.5,) * 8)


def test_curves_are_written_and_a_second_call_searches_nothing(tmp_path, monkeypatch, capfd):
    arguments = [
        "adreft",
        "--robustness",
        "--budget",
        "12",
        "--policy",
        "modular",
        "--families",
        "S4,S5",
        "--methods",
        "none",
        "--work",
        str(tmp_path / "work"),
        "--out",
        str(tmp_path / "out"),
        "--workers",
        "1",
    ]
    monkeypatch.setattr(bench_robustness, "evaluate", toy)
    assert main(arguments) == 0
    content = json.loads((tmp_path / "out" / "adreft-robustness.json").read_text())
    page = (tmp_path / "out" / "adreft-robustness.md").read_text()
    assert "| no repair |" in page
    assert "Made by `" in page
    assert [*content["policies"]["modular"]] == ["random", "avfuzzer", "behavexplor"]
    for curves in content["policies"]["modular"].values():
        curve = curves["none"]
        assert (curve["evaluations"][0], curve["evaluations"][-1]) == (0, 24)
        assert len(curve["found"]) == 3
        for run in curve["found"]:
            assert run == sorted(run)
            assert 0 < run[-1] < 24
    assert len({str(run) for run in content["policies"]["modular"]["random"]["none"]["found"]}) > 1  # other seeds
    assert "modular, random, none: [" in capfd.readouterr().out

    monkeypatch.setattr(bench_robustness, "evaluate", lambda *_, **__: pytest.fail("was searched again"))
    assert main(arguments) == 0
    again = json.loads((tmp_path / "out" / "adreft-robustness.json").read_text())
    assert again["policies"] == content["policies"]
