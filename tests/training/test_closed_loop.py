"""Cases in closed loop: what they come to, whatever the number of workers, and how it is summed up."""

import pytest

from roadmend.core.errors import InputError, RoadmendError
from roadmend.measures.case_result import CaseResult
from roadmend.repair.registry import METHODS
from roadmend.training.closed_loop import evaluate_cases, summarise
from tests.measures.failing import ENTRY, SAID
from tests.measures.results import episode

from .cases import Drawn

CASES = [Drawn("S5", 3), Drawn("S4", 1), Drawn("S5", 4)]


def result(is_violation, outcome, *, ticks=100, interventions=0, change=0.0):
    return CaseResult("", "S1", is_violation, episode(outcome, ticks, interventions, change))


def test_the_results_do_not_depend_on_the_workers():
    one = evaluate_cases(CASES, "modular", "random", {"probability": 0.3})
    two = evaluate_cases(CASES, "modular", "random", {"probability": 0.3}, workers=2)
    assert one == two
    assert [entry.case for entry in one] == ["S5-3", "S4-1", "S5-4"]
    assert all(entry.episode.interventions for entry in one)
    alone = evaluate_cases(CASES[:1], "modular", "none")
    assert alone[0].episode.interventions == 0 == alone[0].episode.dose
    assert alone[0].episode.digest != one[0].episode.digest


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


def test_what_the_guard_does_for_a_method_that_failed_is_not_counted(monkeypatch):
    monkeypatch.setitem(METHODS, "failing", ENTRY)
    with pytest.raises(RoadmendError) as raised:
        evaluate_cases(CASES[:1], "modular", "failing")
    assert str(raised.value) == SAID


def test_a_stop_is_no_fix_and_a_late_success_no_degradation():
    summary = summarise(
        [
            result(True, "GOAL", interventions=10, change=10.0),
            result(True, "TIMEOUT", interventions=30, change=60.0),
            result(True, "COLLISION"),
            result(True, "GOAL", change=10.0),
            result(False, "GOAL"),
            result(False, "COLLISION", change=20.0),
            result(False, "OFF_ROUTE"),
            result(False, "TIMEOUT"),
        ]
    )
    assert (summary.violations, summary.successes) == (4, 4)
    assert (summary.fix, summary.fix_loose, summary.deg, summary.late) == (50.0, 75.0, 25.0, 50.0)
    assert (summary.delta_e, summary.delta_e_loose) == (25.0, 50.0)
    assert summary.intensity == pytest.approx(100 / 40)
    assert (summary.dose, summary.dose_success) == (1.0, 0.25)
    assert summary.intervened_frames == 5.0
    assert summary.as_dict()["fix"] == 50.0


def test_nothing_sums_up_to_nothing():
    assert set(summarise([]).as_dict().values()) == {0.0}
