"""``roadmend bench safe`` on one report."""

import json

from bench import main
from tests.cli.head_on import HEAD_ON, write_report


def test_bench_writes_the_figures_with_the_papers_beside(tmp_path):
    report = write_report(tmp_path / "reports")
    (report / "head-on" / "oracle.json").write_text(json.dumps(HEAD_ON), encoding="utf-8")
    options = ["--policy", "modular", "--samples", "1", "--budget", "12", "--workers", "1"]
    assert main(["safe", str(report), *options, "--work", f"{tmp_path}/work", "--out", f"{tmp_path}/bench"]) == 0
    content = json.loads((tmp_path / "bench" / "safe.json").read_text(encoding="utf-8"))
    assert {*content["extraction"]} >= {"road", "actors", "env", "overall"}
    assert content["extraction"]["actors"] == 0.0, "the oracle says SUV, the report Pickup"
    assert (content["reports"], content["built"], content["scenarios"]) == (1, 1, 2)
    assert {*content["violations"]} == {*content["reproduced"]} == {"modular"}
    assert content["seconds_per_scenario"] > 0.0
    assert content["paper"]["reproduced"]["IDM"] == 15
    assert "15 of 50" in (tmp_path / "bench" / "safe.md").read_text(encoding="utf-8")
