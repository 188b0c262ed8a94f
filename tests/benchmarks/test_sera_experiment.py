"""The benchmark of SERA without driving: sets, arms, forgetting, summary and page, from a kept_runs that answers at once."""

import json
from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest

from harness.sera_experiment import Experiment, means
from harness.sera_page import build_page, write_sera
from harness.sera_plan import (
    bank_entries,
    evaluation_set,
    halves,
    known_scenarios,
    load_corpora,
    read_sera_plan,
)
from harness.sera_summary import build_content, main_rows, tables
from roadmend.core.errors import InputError
from roadmend.measures.driving import DrivingMeasures
from roadmend.networks.checkpoint import save_checkpoint
from roadmend.sera.bank import Bank, build_bank
from roadmend.sera.pattern import FailurePattern
from roadmend.training.few_shot_settings import FewShotSettings

CONFIG = Path(__file__).parents[2] / "config"
PLANS = Path(__file__).parent
GOOD = DrivingMeasures("GOAL", 100.0, (), 100.0, True, 80.0, 90.0, False)
BAD = replace(GOOD, outcome="COLLISION", driving_score=30.0, success=False)
MACHINE = {"processor": "some", "cores": 2, "python": "3"}
MADE = {"command": "c", "commit": "0" * 40, "dirty": False, "machine": MACHINE}


class KeptRuns:
    """Tuning on n scenarios mends the first n hard ones of what is driven; one epoch is kept, or none of nothing."""

    def __init__(self, folder: Path, hard: set[str]) -> None:
        self.folder = folder
        self.hard = hard
        self.lessons = dict[str, int]()
        self.validations = list[int]()

    def drive(self, model, scenarios):
        left = self.lessons.get(model.name, 0)
        found = []
        for scenario in scenarios:
            fails = scenario.digest in self.hard and left <= 0
            left -= scenario.digest in self.hard
            found.append(BAD if fails else GOOD)
        return found

    def tune(self, model, scenarios, settings, seed, validation):
        assert not {scenario.digest for scenario in scenarios} & {scenario.digest for scenario in validation}
        path = self.folder / f"{len(self.lessons)}.safetensors"
        kept = {"epochs": 0 if seed == 1 else settings.epochs}
        header = {"kind": "neural", "configuration": {}, "data_digest": "", "metrics": {"kept": kept}, "ancestry": []}
        save_checkpoint(path, {}, header)
        self.lessons[path.name] = len(scenarios)
        self.validations.append(len(validation))
        return path


@pytest.fixture(scope="module")
def plan():
    return read_sera_plan(PLANS / "sera.yaml", quick=True)


@pytest.fixture(scope="module")
def evaluated(plan):
    return evaluation_set(plan.evaluation, load_corpora(plan.evaluation, CONFIG))


@pytest.fixture(scope="module")
def bank(plan, evaluated, tmp_path_factory):
    path = tmp_path_factory.mktemp("bank") / "small.bank"
    build_bank(path, bank_entries(plan.bank, CONFIG, known_scenarios(evaluated)))
    with Bank(path) as opened:
        yield opened


@pytest.fixture(scope="module")
def results(plan, evaluated, bank, tmp_path_factory):
    hard = {each.scenario.digest for each in evaluated if each.is_hard}
    kept_runs = KeptRuns(tmp_path_factory.mktemp("models"), hard)
    patterns = (FailurePattern("cut-in", "a car cuts in"), FailurePattern("crossing", "a pedestrian crosses"))
    experiment = Experiment(
        Path("base.safetensors"),
        plan,
        FewShotSettings(),
        evaluated,
        bank,
        kept_runs,
        lambda failed: patterns * bool(failed),
        in_depth=True,
    )
    return experiment.run()


def test_the_full_plan_asks_for_what_the_paper_shows():
    whole = read_sera_plan(PLANS / "sera.yaml")
    assert (len(whole.policies), whole.seeds) == (3, 5)
    assert whole.in_depth
    assert not whole.few_shot  # the figures are of the shipped settings
    assert {*whole.in_depth} <= {*whole.policies}
    assert whole.sweep.epochs == [1, 2, 5]
    assert whole.sweep.learning_rates == [1e-5, 5e-5, 1e-4]


@pytest.mark.parametrize("text", ["[", "3", "policies: [neural]", None])
def test_a_file_that_is_no_plan_is_refused(tmp_path, text):
    path = tmp_path / "plan.yaml"
    if text is not None:
        path.write_text(text)
    with pytest.raises(InputError, match="plan"):
        read_sera_plan(path)


def test_the_bank_holds_none_of_the_evaluation_set(evaluated, bank):
    known = known_scenarios(evaluated)
    assert len(bank) > 100
    assert not any(known.holds(entry.scenario) for entry in bank.entries())
    renamed = evaluated[0].scenario.model_copy(update={"name": "another"})
    assert known.holds(renamed)


def test_halves_are_disjoint_whole_alike_and_drawn_by_the_seed(evaluated):
    first, second = halves(evaluated, 0)
    digests = [{each.scenario.digest for each in half} for half in (first, second)]
    assert not digests[0] & digests[1]
    assert len(digests[0] | digests[1]) == len(evaluated)
    counts = [Counter((each.scenario.family, each.is_hard) for each in half) for half in (first, second)]
    assert all(abs(counts[0][key] - counts[1][key]) <= 1 for key in counts[0] | counts[1])
    assert halves(evaluated, 0) == (first, second)
    assert halves(evaluated, 1) != (first, second)


def test_every_arm_is_measured_on_the_same_half_and_an_unchanged_policy_is_not_driven_again(results):
    first, second = results["seeds"]
    assert set(first["arms"]) == {"base", "random", "initial", "full", "half_bank"}
    assert first["arms"]["full"]["success_rate"] > first["arms"]["base"]["success_rate"]
    assert set(second["kept_epochs"].values()) == {0}
    assert all(arm == second["arms"]["base"] for arm in second["arms"].values())
    assert [(row["epochs"], row["learning_rate"]) for row in results["sweep"]] == [(1, 1e-4)]


def test_a_policy_that_is_not_looked_at_in_depth_has_neither_half_a_bank_nor_a_sweep(plan, evaluated, bank, tmp_path):
    patterns = (FailurePattern("cut-in", "a car cuts in"),)
    hard = {each.scenario.digest for each in evaluated if each.is_hard}
    experiment = Experiment(
        Path("base.safetensors"),
        plan,
        FewShotSettings(),
        evaluated,
        bank,
        KeptRuns(tmp_path, hard),
        lambda failed: patterns * bool(failed),
        in_depth=False,
    )
    found = experiment.run()
    assert {arm for one in found["seeds"] for arm in one["arms"]} == {"base", "random", "initial", "full"}
    assert found["sweep"] == []


def test_means_leave_out_what_is_not_known():
    found = means([GOOD, replace(BAD, efficiency=None, comfortness=None)])
    assert found == {"driving_score": 65.0, "success_rate": 50.0, "efficiency": 80.0, "comfortness": 90.0}
    assert means([replace(GOOD, efficiency=None)])["efficiency"] is None


def test_a_policy_that_fails_nowhere_is_said_to(plan, evaluated, bank, tmp_path):
    experiment = Experiment(
        Path("base.safetensors"),
        plan,
        FewShotSettings(),
        evaluated,
        bank,
        KeptRuns(tmp_path, set()),
        lambda _failed: (),
        in_depth=False,
    )
    with pytest.raises(InputError, match="no failure of base"):
        experiment.run()


def test_the_figures_are_written_in_the_fields_that_others_read(results, tmp_path):
    retrieval = {"n": 1000, "p95_ms": 4.5, "recall_at_10": 0.995, "more": 1}
    plan = {"evaluation": {"successes": 3, "ordinary": 3}}
    sizes = {"seeds": 2, "bank": 200, "evaluation": 40, "hard": 10, "split": "test", "plan": plan}
    content = build_content({"neural": results}, retrieval, MADE, sizes)
    write_sera(tmp_path, "sera", content)
    read = json.loads((tmp_path / "sera.json").read_text())
    for arm in ("base", "random", "initial", "full"):
        assert set(read["summary"]["neural"][arm]) == {"driving_score", "success_rate", "efficiency", "comfortness"}
    base, full = (read["summary"]["neural"][arm]["driving_score"] for arm in ("base", "full"))
    assert read["comparisons"]["neural"]["gain_percent"] == pytest.approx(100.0 * (full / base - 1.0))
    assert read["forgetting"]["neural"]["driving_score_change"] == 0.0
    assert read["forgetting"]["neural"]["redrawn_before"] == 100.0
    assert read["forgetting"]["neural"]["redrawn_change"] == 0.0
    assert read["retrieval"] == {"n": 1000, "p95_ms": 4.5, "recall_at_10": 0.995}
    text = (tmp_path / "sera.md").read_text()
    assert f"{full:.1f}" in text
    assert all(f"## {table.title}" in (tmp_path / "sera-tables.md").read_text() for table in tables(content))
    page = (tmp_path / "sera.html").read_text()
    assert page.count("data:image/svg+xml") == 2
    assert page == build_page(content)
    assert len(main_rows(content)) == 1 + 5
    assert build_content({"neural": results}, None, MADE, sizes)["retrieval"] is None
