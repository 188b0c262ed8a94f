"""What is measured behind a policy is what was made for it, whoever asks: evaluate, search, a bag's other method."""

from roadmend.cli.bag_repair import RepairChoice
from roadmend.measures.evaluation import trials_of
from roadmend.measures.fitting import fitting
from roadmend.repair.registry import make_method
from roadmend.search.evaluation import Subject
from roadmend.world.families import sample_scenario


def test_an_evaluation_takes_the_model_of_each_policy():
    trials = trials_of([sample_scenario("S3", 1)], ["modular", "neural"], ["adreft"])
    models = {
        trial.policy: make_method(trial.method, trial.parameters).model.digest
        for trial in trials
        if trial.method == "adreft"
    }
    assert len(set(models.values())) == 2
    assert {trial.policy: dict(trial.parameters) for trial in trials if trial.method == "none"} == {
        "modular": {},
        "neural": {},
    }
    plain = trials_of([sample_scenario("S3", 1)], ["neural"], ["adreft"], is_tuned=False)
    assert not plain[-1].parameters
    assert plain[-1].key != trials[-1].key


def test_a_search_takes_it_too():
    assert Subject("S3", "neural", "adreft", 0).repair == {"model": "neural"}
    assert Subject("S3", "neural", "none", 0).repair == {}


def test_another_method_for_a_bag_takes_it_unless_told_otherwise():
    choice = RepairChoice("adreft", {"threshold": 0.3}, 0)
    assert choice.behind("neural").parameters == {"model": "neural", "threshold": 0.3}
    assert RepairChoice("adreft", {"model": "modular"}, 0).behind("neural").parameters == {"model": "modular"}
    assert choice.behind("external:/theirs").parameters == {"threshold": 0.3}
    assert choice.behind("theirs:Driver").parameters == {"threshold": 0.3}
    assert RepairChoice("rss", {}, 0).behind("modular").parameters == fitting("rss", "modular")


def test_two_models_of_the_gate_do_not_share_kept_results():
    assert (
        make_method("gated", {"model": "modular"}).model_digest
        != make_method("gated", {"model": "neural"}).model_digest
    )
