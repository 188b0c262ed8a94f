"""The table of ``roadmend bench safe`` from figures that are there, and from those that are not."""

import json
from pathlib import Path

from harness.safe_rows import SURE, right_of, rows_of

COMMITTED = json.loads((Path(__file__).parent / "safe.json").read_text(encoding="utf-8"))


def test_where_no_field_was_read_with_confidence_there_is_a_dash():
    content = json.loads(json.dumps(COMMITTED))
    sure = 0
    for found in filter(None, content["extraction"].values()):
        bins = found["calibration"]
        for each in bins["text_only"] if isinstance(bins, dict) else bins:
            if each["low"] == SURE:
                each |= {"count": 0, "right": None}
                sure += 1
    titles = {row[0]: row[1] for row in rows_of(content) if row[0].startswith("fields given with a confidence of 0.9")}
    assert sure == len(titles) > 0
    assert {*titles.values()} == {"-"}


def test_a_share_says_of_how_many_it_is():
    assert right_of({"right": 0.875, "count": 8}) == "87.5 % of 8"


def test_reproductions_and_controls_are_told_by_kind_of_crash():
    rows = {row[0]: row[1:-1] for row in rows_of(COMMITTED)}
    control = "control: without search, one random draw"
    assert rows["crashes reproduced, by the judge"] == ["39 of 57", "42 of 57"]
    assert rows["with the policy as an onlooker of a vehicle that crashes alone"] == ["11 of 12", "11 of 12"]
    assert rows["with two vehicles or more"] == ["28 of 45", "31 of 45"]
    assert rows[control] == ["20 of 57", "19 of 57"]
    assert rows[f"{control}: a vehicle alone"] == ["10 of 12", "11 of 12"]
    assert rows[f"{control}: two vehicles or more"] == ["10 of 45", "8 of 45"]


def test_without_records_and_other_texts_there_is_neither_a_judgement_nor_a_row_of_it():
    content = json.loads(json.dumps(COMMITTED))
    assert any("one random draw" in row[0] for row in rows_of(content))
    content["records"]["records"] = 0
    content["extraction"]["other_registers"] = None
    for ablation in content["ablations"].values():
        ablation.get("extraction", {})["other_registers"] = None
    titles = [row[0] for row in rows_of(content)]
    assert not any("one random draw" in title or "by the judge" in title for title in titles)
    assert not any("other registers" in title for title in titles)
