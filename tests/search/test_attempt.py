"""Errors of the scenario are what it came to; errors of the machine end the work and are never kept."""

from types import SimpleNamespace

import pytest

from roadmend.core.errors import ForeignError, InputError, RoadmendError, SimulationError
from roadmend.core.journal import Journal
from roadmend.search import persistence, rerun
from roadmend.search.attempt import Attempt, fault_of
from roadmend.search.evaluation import NamedPoint, Subject, evaluate
from roadmend.search.persistence import PersistenceTeller
from roadmend.search.rerun import Rerunner
from roadmend.world.families import sample_scenario
from tests.measures.results import episode


@pytest.mark.parametrize("error", [SimulationError("SUMO\nfailed"), ForeignError("a", "b", "c"), KeyError("lost")])
def test_an_error_of_the_scenario_is_told_in_one_line(error):
    assert fault_of(error) == " ".join(f"{type(error).__name__}: {error}".split())


@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), MemoryError()])
def test_an_error_of_the_machine_ends_the_work(error):
    with pytest.raises(SimulationError, match="run the same command again to go on"):
        fault_of(error)
    told = InputError("cache", "cannot be written", "choose another")
    told.__context__ = error
    with pytest.raises(InputError) as caught:
        fault_of(told)
    assert caught.value is told


def test_a_cache_that_cannot_be_written_ends_a_search(tmp_path, monkeypatch):
    (tmp_path / "file").touch()
    monkeypatch.setenv("ROADMEND_CACHE", str(tmp_path / "file" / "cache"))
    subject = Subject("S3", "modular", "none", 77123)
    monkeypatch.setattr(Subject, "scenario", lambda *_: sample_scenario("S3", 77123))
    with pytest.raises(InputError, match="cannot be written"):
        evaluate(subject, NamedPoint("one", {}))


@pytest.fixture
def case():
    return SimpleNamespace(scenario=lambda: sample_scenario("S5", 3), duration=9.0, is_violation=True)


def test_a_fault_of_a_rerun_is_not_kept(tmp_path, monkeypatch, case):
    found = [Attempt(None, "SimulationError: lost"), Attempt(episode("GOAL"), "")]
    monkeypatch.setattr(rerun, "rerun", lambda _policy, _case: found.pop(0))
    with Journal(tmp_path / "kept.jsonl", rerun.FORMAT) as journal:
        rerunner = Rerunner("modular", map, journal)
        assert [each.outcome for _ in range(3) for each in rerunner([case])] == ["CRASH", "GOAL", "GOAL"]


def test_futures_that_could_not_be_driven_are_driven_again(tmp_path, monkeypatch, case):
    found = [None, 0.5]
    monkeypatch.setattr(persistence, "_answer", lambda _question: found.pop(0))
    with Journal(tmp_path / "kept.jsonl", persistence.FORMAT) as journal:
        teller = PersistenceTeller("modular", map, journal)
        assert [each for _ in range(3) for each in teller([case], 5)] == [None, 0.5, 0.5]


def test_an_error_of_the_machine_is_no_persistence(monkeypatch, case):
    def fails(*_):
        error = RoadmendError("the disk is full")
        error.__context__ = OSError(28, "No space left on device")
        raise error

    monkeypatch.setattr(persistence, "persistence", fails)
    with pytest.raises(RoadmendError, match="the disk is full"):
        persistence._answer(persistence._Question(case, "modular", 5))
