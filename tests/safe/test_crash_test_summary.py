"""Counting what jobs came to."""

from roadmend.core.outcome import Blame
from roadmend.safe.cases import CrashCase
from roadmend.safe.crash_test_summary import summarise_reproductions, summarise_tests
from roadmend.safe.driving import CrashTestResult
from tests.measures.results import episode

from .crashes import ALL, CROSSING

CASES = [
    CrashCase("a", CROSSING),
    CrashCase("b", CROSSING),
    CrashCase("c", ALL["alone"]),
    CrashCase("d", None, problem="no"),
]


def result(report, outcome="GOAL", *, fault=False, reproduced=None, vehicle=1):
    return CrashTestResult(
        report,
        vehicle,
        "modular",
        driven=episode(outcome, blame=Blame.FRONT if fault else Blame.UNKNOWN) if outcome else None,
        reproduced=reproduced,
        episodes=3,
        seconds=0.5,
    )


def test_tests_are_counted_in_the_order_of_the_reports():
    results = [
        result("a"),
        result("a", "COLLISION", fault=True),
        result("b", "TIMEOUT"),
        result("b", "COLLISION"),
        result("b", ""),
        result("c", "COLLISION"),
        result("c", "COLLISION"),
    ]
    found = summarise_tests(CASES, results)
    assert (found.reports, found.built, found.scenarios, found.collisions, found.at_fault) == (4, 2, 6, 4, 1)
    assert found.top == (2, 4, 5)
    assert found.violation_rate == 4 / 6
    assert found.seconds_per_scenario == 0.5
    assert found.cells()[-3:] == ("66.7 %", "2/4/5", "0.50")


def test_nothing_at_all_is_no_division_by_zero():
    found = summarise_tests(CASES, [])
    assert (found.built, found.violation_rate, found.seconds_per_scenario) == (0, None, None)
    assert found.cells()[-3:] == ("-", "-", "-")


def test_a_crash_counts_once_whoever_was_the_ego():
    results = [
        result("a", "COLLISION", reproduced=True),
        result("a", "COLLISION", reproduced=True, vehicle=2),
        result("b", "", reproduced=False),
        result("c", "", reproduced=False),
    ]
    found = summarise_reproductions(CASES, results)
    assert (found.reports, found.possible, found.reproduced, found.names, found.episodes) == (4, 2, 1, ("a",), 12)
    assert found.cells() == ("4", "1", "25.0 %", "1 of 2 (50.0 %)", "12")
