"""``roadmend bench safe`` on one report."""

import json

from bench import main
from tests.cli.head_on import HEAD_ON, write_report

RECORD = {
    "case": "head-on",
    "oracle": None,
    "crash": {
        "road": "Straight",
        "vehicles": [
            {"number": 1, "from": "E", "to": "E", "manoeuvre": "move forward"},
            {"number": 2, "from": "W", "to": "W", "manoeuvre": "drift left"},
        ],
        "collisions": [{"striking": 2, "struck": 1, "striking_part": "front", "struck_part": "front"}],
        "doubt": "",
    },
    "annotator": "the test",
}


def test_bench_writes_the_figures_with_the_papers_beside(tmp_path):
    report = write_report(tmp_path / "reports")
    (report / "head-on" / "oracle.json").write_text(json.dumps(HEAD_ON), encoding="utf-8")
    (tmp_path / "records").mkdir()
    (tmp_path / "records" / "head-on.json").write_text(json.dumps(RECORD), encoding="utf-8")
    (tmp_path / "texts").mkdir()
    options = ["--policy", "modular", "--samples", "1", "--budget", "12", "--workers", "1"]
    options += [
        "--crash-records",
        f"{tmp_path}/records",
        "--texts",
        f"{tmp_path}/texts",
        "--work",
        f"{tmp_path}/work",
        "--out",
        f"{tmp_path}/bench",
    ]
    assert main(["safe", str(report), *options]) == 0
    content = json.loads((tmp_path / "bench" / "safe.json").read_text(encoding="utf-8"))
    read = content["extraction"]["other"]
    assert {*read} >= {"road", "actors", "env", "overall", "with_sketch", "calibration"}
    assert read["actors"] == 0.0, "the oracle says SUV, the report Pickup"
    assert (content["reports"], content["built"], content["scenarios"]) == (1, 1, 2)
    assert content["seconds_per_scenario"] > 0.0
    assert content["paper"]["reproduced"]["IDM"] == 15
    found = content["reproduction"]
    assert (found["reports"], found["built"], found["reproduced"]) == (1, 1, 1)
    own = found["policies"]["modular"]
    assert (own["by_own_reading"], own["shown"], own["collisions"], own["unphysical"]) == (1, 1, 1, 0)
    assert content["ablations"]["search"]["reproduction"]["modular"]["episodes"] in {1, 2}  # a draw for each role
    assert content["records"] == {
        "records": 1,
        "single_vehicle": 0,
        "with_coded_fields": 0,
        "statements_compared": 0,
        "statements_contradicted": 0,
    }
    assert "15 of 50" in (tmp_path / "bench" / "safe.md").read_text(encoding="utf-8")
