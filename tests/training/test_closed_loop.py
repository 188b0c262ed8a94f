"""Cases in closed loop: what they come to, whatever the number of workers, and how it is summed up."""

import math

import pytest

from roadmend.core.errors import InputError
from roadmend.training.closed_loop import CaseResult, evaluate_cases, summarise

from .cases import Drawn

CASES = [Drawn("S5", 3), Drawn("S4", 1), Drawn("S5", 4)]


def result(is_violation, outcome, *, ticks=100, interventions=0, intensity=0.0, dose=0.0):
    return CaseResult("", "S1", is_violation, outcome, ticks, interventions, intensity, dose, math.inf, "")


def test_the_results_do_not_depend_on_the_workers():
    one = evaluate_cases(CASES, "modular", "random", {"probability": 0.3})
    two = evaluate_cases(CASES, "modular", "random", {"probability": 0.3}, workers=2)
    assert one == two
    assert [entry.name for entry in one] == ["S5-3", "S4-1", "S5-4"]
    assert all(entry.interventions for entry in one)
    alone = evaluate_cases(CASES[:1], "modular", "none")
    assert alone[0].interventions == 0 == alone[0].dose
    assert alone[0].digest != one[0].digest


def test_results_are_reported_as_they_come():
    seen = []
    results = evaluate_cases(CASES[:2], "modular", "none", report=seen.append)
    assert seen == results


@pytest.mark.parametrize(
    ("policy", "method", "parameters"),
    [("nobody", "none", {}), ("modular", "magic", {}), ("modular", "random", {"probability": 2.0})],
)
def test_what_cannot_be_is_said_before_anything_runs(policy, method, parameters):
    with pytest.raises(InputError):
        evaluate_cases(CASES, policy, method, parameters)


def test_a_stop_is_no_fix_and_a_late_success_no_degradation():
    summary = summarise(
        [
            result(True, "GOAL", interventions=10, intensity=1.0, dose=0.5),
            result(True, "TIMEOUT", interventions=30, intensity=2.0, dose=3.0),
            result(True, "COLLISION"),
            result(True, "GOAL", dose=0.5),
            result(False, "GOAL"),
            result(False, "COLLISION", dose=1.0),
            result(False, "OFF_ROUTE"),
            result(False, "TIMEOUT"),
        ]
    )
    assert (summary.violations, summary.successes) == (4, 4)
    assert (summary.fix, summary.fix_loose, summary.deg, summary.late) == (50.0, 75.0, 25.0, 50.0)
    assert (summary.delta_e, summary.delta_e_loose) == (25.0, 50.0)
    assert summary.intensity == pytest.approx((10 * 1.0 + 30 * 2.0) / 40)
    assert (summary.dose, summary.dose_success) == (1.0, 0.25)
    assert summary.intervened_frames == 5.0
    assert summary.as_dict()["fix"] == 50.0


def test_nothing_sums_up_to_nothing():
    assert set(summarise([]).as_dict().values()) == {0.0}
