"""One episode of an evaluation set: whatever goes wrong in it is told with its name."""

from roadmend.repair.registry import METHODS
from roadmend.sera.evaluation_episode import EvaluatedEpisode, EvaluationJob, evaluate
from roadmend.world.families import sample_scenario
from tests.measures.failing import ENTRY, SAID


def test_an_episode_in_which_the_method_failed_has_no_measures(monkeypatch, tmp_path):
    monkeypatch.setitem(METHODS, "failing", ENTRY)
    job = EvaluationJob(sample_scenario("S5", 3), "modular", "failing", tmp_path / "bags", "all", "key")
    assert evaluate(job) == EvaluatedEpisode(fault=f"S5-3: {SAID}")
    assert not [*tmp_path.iterdir()]
