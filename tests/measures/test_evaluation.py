"""What is made of a method beside the policy alone."""

from dataclasses import replace

import pytest

from roadmend.core.journal import Journal
from roadmend.core.outcome import Blame
from roadmend.measures import evaluation, registry
from roadmend.measures.evaluation import Driven, EvaluationTrial, drive_trial, run_trials, trials_of
from roadmend.measures.evaluation_figures import evaluate, evaluation_rows, meanings
from roadmend.measures.registry import Column, Measure
from roadmend.repair.registry import METHODS
from roadmend.world.families import sample_scenario
from roadmend.world.scenario_networks import NetworkFile, SumoConfiguration

from .failing import ENTRY, SAID
from .results import episode

SCENARIOS = [sample_scenario("S3", seed) for seed in range(4)]


def driven(method, outcomes):
    return [
        Driven(
            EvaluationTrial(scenario, "modular", method, method),
            replace(
                episode(outcome, blame=Blame.FRONT if outcome == "COLLISION" else Blame.UNKNOWN), scenario=scenario.name
            ),
        )
        for scenario, outcome in zip(SCENARIOS, outcomes, strict=True)
    ]


def test_what_the_policy_does_alone_decides_what_can_be_fixed_and_degraded():
    alone = driven("none", ["COLLISION", "COLLISION", "GOAL", "TIMEOUT"])
    figures = evaluate(alone + driven("rss", ["GOAL", "COLLISION", "COLLISION", "GOAL"]))["modular"]
    assert (figures["none"]["repair"]["fix"], figures["none"]["repair"]["deg"]) == (0.0, 0.0)
    assert (figures["rss"]["repair"]["fix"], figures["rss"]["repair"]["deg"]) == (50.0, 100.0)
    assert figures["rss"]["goal"]["share"] == 50.0
    assert figures["rss"]["outcomes"] == {"GOAL": 2, "COLLISION": 2}
    assert evaluation_rows({"modular": figures})[2][:4] == ["modular", "rss", "4", "50.0"]


def test_whom_others_strike_without_a_fault_of_his_has_nothing_to_be_repaired_and_was_not_spoilt():
    alone, repaired = driven("none", ["COLLISION", "COLLISION", "GOAL", "GOAL"]), driven("rss", ["GOAL"] * 4)
    struck = episode("COLLISION", blame=Blame.EGO_STOOD)
    alone[0] = Driven(alone[0].trial, replace(struck, scenario=SCENARIOS[0].name))
    found = evaluate(alone + repaired)["modular"]["rss"]["repair"]
    assert (found["violations"], found["successes"], found["fix"]) == (1, 2, 100.0)


def test_the_table_keeps_its_columns():
    heading, row = evaluation_rows({"modular": evaluate(driven("none", ["COLLISION", "GOAL"] * 2))["modular"]})
    cells = iter(zip(heading, row, strict=True))
    for cell in [
        ("policy", "modular"),
        ("repair", "none"),
        ("episodes", "4"),
        ("goal [%]", "50.0"),
        ("95 %", "15.0 .. 85.0"),
        ("collision [%]", "50.0"),
        ("%Fix", "0.0"),
        ("%Deg", "0.0"),
        ("ΔE", "0.0"),
        ("95 %", "-65.8 .. 65.8"),
        ("dose [s]", "0.00"),
    ]:
        assert cell in cells  # behind the one before; others may stand between


def test_one_line_adds_a_measure_to_the_figures_the_table_and_the_help(monkeypatch):
    longest = Measure(
        lambda episodes: max(result.duration for result in episodes.results),
        (Column("longest", "s", "lower", "episode"),),
    )
    monkeypatch.setitem(registry.MEASURES, "longest", longest)
    figures = evaluate(driven("none", ["GOAL"] * 4))
    assert figures["modular"]["none"]["longest"] == 10.0
    rows = evaluation_rows(figures)
    assert (rows[0][-1], rows[1][-1]) == ("longest [s]", "10.0")
    assert meanings().endswith("; longest [s]: episode, lower is better")


def test_a_policy_that_could_not_be_driven_alone_has_no_figures():
    assert evaluate([replace(each, result=None) for each in driven("none", ["GOAL"] * 4)]) == {}
    assert evaluate(driven("rss", ["GOAL"] * 4)) == {}


def test_every_method_is_tried_once_with_the_trivial_ones():
    trials = trials_of(SCENARIOS[:1], ["modular"], ["rss", "none"])
    assert [trial.method for trial in trials] == ["none", "random", "rss"]
    assert len({trial.key for trial in trials}) == 3
    assert trials_of(SCENARIOS[:1], ["modular", "modular"], ["rss", "rss"]) == trials


@pytest.mark.parametrize("kind", [NetworkFile, SumoConfiguration])
def test_what_is_kept_holds_for_the_network_as_it_was(kind, tmp_path, monkeypatch):
    drives = []

    def run(scenario, *_):
        drives.append(scenario)
        return replace(episode("GOAL"), scenario=scenario.name)

    monkeypatch.setattr(evaluation, "run_episode", run)
    net, configuration = tmp_path / "a.net.xml", tmp_path / "a.sumocfg"
    configuration.write_text('<configuration><net-file value="a.net.xml"/></configuration>')
    network = kind(path=str(net if kind is NetworkFile else configuration))
    scenario = SCENARIOS[0].model_copy(update={"network": network})
    with Journal(tmp_path / "kept.jsonl", "test/1") as journal:
        for number, text in enumerate(["<net/>", "<net/>", "<net></net>", None, "<net/>"]):
            net.unlink() if text is None else net.write_text(text)
            trial = EvaluationTrial(scenario, "modular", "none", "x")
            assert run_trials([trial], journal, 1)[0].result.scenario == scenario.name
            assert len(drives) == (1, 1, 2, 3, 3)[number]


@pytest.mark.parametrize("error", [ValueError("on\npurpose"), KeyError("x")])
def test_what_goes_wrong_in_an_episode_is_one_line(error, monkeypatch):
    def fail(*_):
        raise error

    monkeypatch.setattr(evaluation, "run_episode", fail)
    fault = drive_trial(EvaluationTrial(SCENARIOS[0], "modular", "none", "x")).fault
    assert fault.startswith(f"{SCENARIOS[0].name}, policy modular, none: {type(error).__name__}: ")
    assert "\n" not in fault


def test_an_episode_in_which_the_method_failed_has_no_result(monkeypatch):
    monkeypatch.setitem(METHODS, "failing", ENTRY)
    told = drive_trial(EvaluationTrial(SCENARIOS[0], "modular", "failing", "x"))
    assert told.result is None
    assert told.fault == f"{SCENARIOS[0].name}, policy modular, failing: RoadmendError: {SAID}"
