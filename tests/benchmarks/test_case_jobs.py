"""Pieces of work: of a method that fails on the way nothing is counted, whoever drove on in its place."""

from dataclasses import replace

import numpy as np
import pytest

from harness.case_jobs import CaseJob, run_job
from harness.contenders import Contender
from harness.control_jobs import ControlJob, control
from harness.grid import Setting
from roadmend.core.errors import RoadmendError
from roadmend.core.parameters import NoParameters
from roadmend.repair.registry import METHODS, MethodEntry
from roadmend.world.corpus import corpus_of
from tests.measures.failing import ENTRY, SAID, FailingMethod

CASE = min(corpus_of("modular").select("S3", "validation", violation=True), key=lambda case: case.duration)
FAILING = Contender("failing", "Failing", "rival", "modular", "failing")
NONE = replace(FAILING, name="none", method="none")


def critical(_case, time, _distance, _end, _outcome):
    return np.zeros(len(time), dtype=np.bool_)


@pytest.fixture(autouse=True)
def _failing(monkeypatch):
    monkeypatch.setitem(METHODS, "failing", ENTRY)


def test_a_case_in_which_the_method_failed_has_no_result():
    told = run_job(CaseJob(CASE, (FAILING,), ("key",)))
    assert not told.results
    assert told.fault == f"{CASE.name}, policy modular, failing: RoadmendError: {SAID}"
    assert run_job(CaseJob(CASE, (NONE,), ("key",))).results


def test_nor_has_one_in_which_it_failed_as_a_monitor():
    told = run_job(CaseJob(CASE, (NONE, FAILING), ("none", "failing"), critical))
    assert not told.results
    assert told.fault == f"{CASE.name}, policy modular, none, failing: RoadmendError: {SAID}"
    assert run_job(CaseJob(CASE, (NONE,), ("none",), critical)).results


def test_controls_of_it_are_refused():
    with pytest.raises(RoadmendError) as raised:
        control(ControlJob(CASE, "modular", Setting("failing", "modular", "failing")))
    assert str(raised.value) == SAID


def test_and_if_it_failed_in_one_of_the_futures_alone(monkeypatch):
    made = []

    def make(_parameters, _seed):
        made.append(FailingMethod(5 if made else 100_000))
        return made[-1]

    monkeypatch.setitem(METHODS, "failing", MethodEntry(NoParameters, make))
    with pytest.raises(RoadmendError) as raised:
        control(ControlJob(CASE, "modular", Setting("failing", "modular", "failing")))
    assert len(made) == 2
    assert str(raised.value) == SAID
