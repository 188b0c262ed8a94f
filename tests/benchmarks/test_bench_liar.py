"""``roadmend bench liar``: lies are lies, the honest pass, and a check that always objects is seen to be worthless."""

import json

import pytest

from bench import main
from harness.crash_oracles import reports_in, sample_reports
from harness.liar import LEFT_OUT, META_ALONE, lies, meta_of
from roadmend.core.errors import InputError
from roadmend.safe.dsl_data import dump_data, parse_data
from roadmend.safe.encoder import encode_meta

KNOWN = sample_reports()
BAR = 95.0  # [%] of planted fields


@pytest.mark.parametrize("known", KNOWN, ids=lambda known: known.report.case)
def test_each_lie_is_one_that_the_language_has(known):
    truth = dump_data(known.truth)
    planted = lies(known.truth, {}, "seed")
    assert planted == lies(known.truth, {}, "seed")
    assert planted != lies(known.truth, {}, "another")
    for lie in planted:
        assert (lie.scenario, lie.meta) != (truth, meta_of(truth))
        assert (lie.scenario == truth) is (lie.where == META_ALONE)
        parse_data(lie.scenario, "a lie")
        encode_meta(json.dumps(lie.meta))
    kinds = {lie.kind for lie in planted}
    assert {"road type", "lanes", "model", "position", "action", "limit", "time", "weather", LEFT_OUT} <= kinds
    assert {"count of vehicles", "side of the collision"} <= kinds


def test_the_figures(tmp_path, capsys):
    assert main(["liar", "--out", str(tmp_path), "--json"]) == 0
    content = json.loads((tmp_path / "liar.json").read_text())
    assert json.loads(capsys.readouterr().out) == content
    assert content["reports"] == 5
    alone, without_reader, full, always = content["checks"].values()
    assert full["planted"] > 100
    assert full["caught_rate"] >= BAR
    assert full["false_alarm_rate"] <= 2.0
    assert alone["caught"] == 0
    assert 0 < without_reader["caught"] < full["caught"]
    assert (always["caught_rate"], always["false_alarm_rate"], always["told_apart"]) == (100.0, 100.0, 0)
    assert "objects to everything" in (tmp_path / "liar.md").read_text()


def test_other_reports_with_oracles(tmp_path, capsys):
    with pytest.raises(InputError, match="holds no report with an oracle"):
        reports_in(tmp_path)
    (tmp_path / "one.txt").write_text(KNOWN[0].report.summary)
    oracle = dump_data(KNOWN[0].truth) | {"alternatives": {"num_lanes": [3, 4, 5, 6, 1]}, "register": "news"}
    (tmp_path / "one.oracle.json").write_text(json.dumps(oracle))
    (one,) = reports_in(tmp_path)
    assert one.truth == KNOWN[0].truth
    assert not any(lie.field == "num_lanes" for lie in lies(one.truth, one.others, "seed") if lie.kind == "lanes")
    (tmp_path / "two").mkdir()
    (tmp_path / "two" / "summary.txt").write_text(KNOWN[1].report.summary)
    (tmp_path / "two" / "oracle.json").write_text("{}")
    assert main(["liar", str(tmp_path)]) == 2
    assert "is no oracle" in capsys.readouterr().err
