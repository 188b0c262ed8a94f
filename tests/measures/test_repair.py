from dataclasses import replace

import pytest

from roadmend.core.episode_result import peaks
from roadmend.measures.case_result import CaseResult
from roadmend.measures.repair import (
    PairedCase,
    advantage,
    advantage_of,
    delta_e_interval,
    intervals_of,
    share_interval,
    share_of_bound,
    summarise,
)

from .results import result, run


def test_figures_by_hand():
    results = [
        result("a", True, "GOAL", 10, 8.0),
        result("b", True, "TIMEOUT", 30, 12.0),
        result("c", True, "COLLISION"),
        result("d", True, "OFF_ROUTE", 10, 20.0, deceleration=6.0),
        result("e", False, "GOAL"),
        result("f", False, "COLLISION", 5, 5.0),
        result("g", False, "TIMEOUT", 5, 5.0),
        result("h", False, "GOAL"),
    ]
    figures = summarise(results)
    assert {name: figures[name] for name in ("violations", "successes", "fix", "fix_loose", "deg", "delta_e")} == {
        "violations": 4,
        "successes": 4,
        "fix": 25.0,
        "fix_loose": 75.0,
        "deg": 25.0,
        "delta_e": 0.0,
    }
    assert figures["delta_e_loose"] == 50.0
    assert (figures["stopped"], figures["goal_lost"], figures["untouched"]) == (25.0, 50.0, 50.0)
    assert figures["intensity"] == pytest.approx(50.0 / 60.0)  # over frames, not over cases
    assert figures["dose"] == pytest.approx(50.0 * 0.05 / 8)
    assert figures["dose_violations"] == pytest.approx(40.0 * 0.05 / 4)
    assert figures["dose_successes"] == pytest.approx(10.0 * 0.05 / 4)
    assert figures["intervened_frames"] == pytest.approx(60 / 8)
    assert figures["peak_deceleration"] == pytest.approx((7 * 2.0 + 6.0) / 8)
    for name, (low, high) in figures["intervals"].items():
        assert low <= figures[name] <= high


def test_a_car_that_only_stops_has_fixed_nothing():
    figures = summarise(run("TTTTTTTT"))
    assert (figures["fix"], figures["fix_loose"], figures["deg"], figures["goal_lost"]) == (0.0, 100.0, 0.0, 100.0)


def test_what_has_no_value_is_none_and_no_zero():
    figures = summarise([result("a", True, "COLLISION")])
    assert figures["deg"] is None
    assert figures["delta_e"] is None
    assert figures["intensity"] is None
    assert figures["intervals"]["intensity"] is None


def test_one_method_against_another_on_the_same_cases():
    more = advantage(run("GGGCGGGG", 2, 2.0), run("GCCCGGGC", 4, 4.0))
    assert more["delta_e"] == pytest.approx(50.0 + 25.0)
    assert more["dose"] == pytest.approx(-0.1)
    assert more["intervals"]["dose"] == pytest.approx([-0.1, -0.1])
    low, high = more["intervals"]["delta_e"]
    assert low < 75.0 < high
    with pytest.raises(ValueError, match="different cases"):
        advantage(run("GGGGGGGG"), run("GGGGGGGG")[::-1])


def named(outcomes, names, violations):
    return [
        PairedCase(name, is_violation, letter == "G", letter == "C", 1.0)
        for letter, name, is_violation in zip(outcomes, names, violations, strict=True)
    ]


def test_cases_of_one_search_count_as_kin():
    violations = [True] * 12 + [False] * 12
    kin = [f"S1-modular-none-random-{10 * v + place // 3 % 4}-{place:05d}" for place, v in enumerate(violations)]
    strangers = [f"S{1 + place % 5}-{12_345 + place}" for place in range(24)]  # as scenarios are called that were drawn
    outcomes = "GGGCCCGGGCCC" + "GGGCCCGGGGGG"
    intervals = [delta_e_interval(named(outcomes, names, violations)) for names in (kin, strangers)]
    assert intervals[0][0] < intervals[1][0] < 25.0 < intervals[1][1] < intervals[0][1]
    leads = [
        advantage_of(named(outcomes, names, violations), named("C" * 12 + "G" * 12, names, violations))
        for names in (kin, strangers)
    ]
    assert [lead["delta_e"] for lead in leads] == [25.0, 25.0]
    assert leads[0]["intervals"]["delta_e"][0] < leads[1]["intervals"]["delta_e"][0]


def test_so_they_do_for_shares_and_doses():
    kin = [f"S1-modular-none-random-{place // 3 % 4}-{place:05d}" for place in range(12)]
    strangers = [f"S{1 + place % 5}-{12_345 + place}" for place in range(12)]
    widths = {}
    for names in (kin, strangers):
        low, high = share_interval([(name, letter == "G") for name, letter in zip(names, "GGGCCCGGGCCC", strict=True)])
        cases = named("GGGCCCGGGCCC", names, [True] * 12)
        amounts = intervals_of(
            [replace(each, dose=float(each.reached_goal), frames=30 * each.reached_goal) for each in cases]
        )
        widths[names[0]] = [
            high - low,
            *(amounts[name][1] - amounts[name][0] for name in ("dose", "intervened_frames")),
        ]
    assert all(one > 1.2 * other for one, other in zip(widths[kin[0]], widths[strangers[0]], strict=True))


def test_of_one_search_alone_nothing_can_be_told_of_others():
    names = [f"S1-modular-none-random-7-{place:05d}" for place in range(4)]
    cases = named("GCGG", names, [True, True, False, False])
    assert advantage_of(cases, cases)["intervals"] == {"delta_e": None, "dose": None}
    assert delta_e_interval(cases[:2]) is None


@pytest.mark.parametrize("count", [0, 1])
def test_one_case_of_each_kind_tells_nothing_of_others(count):
    drawn = ("intensity", "dose", "intervened_frames")
    two = [result("a", True, "GOAL", 4, 2.0), result("b", False, "GOAL")][: 1 + count]
    assert [summarise(two)["intervals"][name] for name in drawn] == [None] * 3
    three = [*two, result("c", True, "GOAL")]
    assert summarise(three)["intervals"]["dose"] is not None


def test_shares_of_the_bound_look_only_at_what_it_repairs():
    bound = {each.case: each for each in run("GGCGGGGG", 5, 2.0)}
    share = share_of_bound(run("GTGGGGGG", 10, 6.0), bound)
    assert share["repairable"] == 3
    assert share["fix_share"] == pytest.approx(200.0 / 3)
    assert share["dose_ratio"] == pytest.approx(3.0)  # on two cases
    assert share["dose_ratio_all"] == pytest.approx(3.0)  # on three


def test_peaks_of_a_constant_deceleration():
    speeds = [20.0] * 20 + [20.0 - 4.0 * 0.05 * tick for tick in range(1, 60)]
    deceleration, jerk, mean = peaks(speeds)
    assert 0.0 < mean < jerk
    assert deceleration == pytest.approx(4.0)
    assert jerk == pytest.approx(4.0 / 0.2)  # from nothing to 4 m/s2 within one window
    assert peaks([10.0, 9.0]) == (0.0, 0.0, 0.0)
    assert peaks([float(tick) for tick in range(30)])[0] == 0.0


def test_a_result_survives_its_dump():
    one = result("a", True, "GOAL", 3, 0.1 + 0.2)
    assert CaseResult.parse(one.dump()) == one
    with pytest.raises(ValueError, match="unexpected"):
        CaseResult.parse({**one.dump(), "other": 1})
