"""Means and intervals of the four measures."""

import pytest

from roadmend.measures.driving import DrivingMeasures
from roadmend.measures.summary import summarise, summary_rows


def one(score, success, efficiency=100.0, comfortness=80.0):
    return DrivingMeasures("GOAL", 100.0, (), score, success, efficiency, comfortness, at_fault=False)


def test_means_leave_out_what_is_not_known():
    found = summarise([one(100.0, True, None), one(40.0, False, 50.0), one(100.0, True, 70.0, None)])
    assert found["driving_score"]["mean"] == 80.0
    assert found["success_rate"]["mean"] == pytest.approx(200.0 / 3.0)
    assert found["efficiency"]["mean"] == 60.0
    assert found["comfortness"]["mean"] == 80.0
    for name in ("driving_score", "success_rate", "efficiency"):
        low, high = found[name]["interval"]
        assert low <= found[name]["mean"] <= high
        assert low < high


def test_more_episodes_of_the_same_kind_make_it_surer():
    few, many = (summarise([one(100.0, True), one(0.0, False)] * count) for count in (4, 64))
    width = lambda found: found["driving_score"]["interval"][1] - found["driving_score"]["interval"][0]
    assert width(many) < 0.5 * width(few)


def test_one_episode_tells_nothing_of_others():
    found = summarise([one(100.0, True)])
    assert {name: found[name]["mean"] for name in ("driving_score", "comfortness")} == {
        "driving_score": 100.0,
        "comfortness": 80.0,
    }
    assert found["driving_score"]["interval"] is found["comfortness"]["interval"] is None
    assert found["success_rate"]["interval"][0] < 50.0
    assert found["efficiency"]["interval"] is None
    assert summarise([one(100.0, True)] * 2)["driving_score"]["interval"] == [100.0, 100.0]


def test_without_episodes_there_is_nothing_to_say():
    rows = summary_rows({"S1": summarise([])})
    assert rows[1][:4] == ["S1", "0", "-", "-"]
    assert set(rows[1][2:]) == {"-"}
