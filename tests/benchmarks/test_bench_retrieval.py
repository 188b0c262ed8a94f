"""``roadmend bench retrieval`` on a small bank."""

import json

from bench import main


def test_the_benchmark_measures_what_it_says(tmp_path, capsys):
    assert main(["retrieval", "--scenarios", "5500", "--queries", "20", "--out", str(tmp_path), "--json"]) == 0
    written = json.loads((tmp_path / "retrieval.json").read_text())
    assert json.loads(capsys.readouterr().out) == written
    assert written["n"] == 5500
    assert 0.9 <= written["recall_at_10"] <= 1.0
    assert 0.0 < written["searches"]["all"]["cpu_p50_ms"] <= written["searches"]["all"]["cpu_p99_ms"]
    assert written["build_peak_memory_bytes"] > written["index_bytes"] > 5500 * 2 * written["dimensions"]
    assert "recall@10" in (tmp_path / "retrieval.md").read_text()
