"""``roadmend bench sera``: the command around the experiment, which is tested on its own."""

import json
from pathlib import Path

import pytest

from bench import main
from harness import bench_sera
from harness.sera_plan import read_sera_plan
from roadmend.core.errors import InputError
from roadmend.training.few_shot_settings import read_few_shot_settings

ARM = {"driving_score": 60.0, "success_rate": 50.0, "efficiency": 80.0, "comfortness": None}
FORGOTTEN = {
    "ordinary": 10,
    "went_well": 0,
    "ordinary_change": 0.0,
    "driving_score_change": None,
    "success_rate_change": None,
    "redrawn_before": None,
    "redrawn_change": None,
}
PLAN = {"evaluation": {"violations": 4, "successes": 2, "ordinary": 2}}
SIZES = {"seeds": 2, "bank": 100, "evaluation": 40, "hard": 20, "split": "test", "plan": PLAN}


def result(gain, *, in_depth=True):
    arms = ("base", "random", "initial", "full", "half_bank")[: 5 if in_depth else 4]
    seeds = [
        {
            "seed": seed,
            "arms": {
                arm: {**ARM, "driving_score": 60.0 + place * gain + seed * (1 + 0.1 * place)}
                for place, arm in enumerate(arms)
            },
            "forgetting": {"full": FORGOTTEN},
        }
        for seed in range(2)
    ]
    return {"seeds": seeds, "sweep": [{"epochs": 1, "learning_rate": 1e-4, **ARM}] if in_depth else []}


@pytest.fixture
def command(tmp_path, monkeypatch):
    plans, evaluated = [], []

    def run(plan, _config, models, corpora, _workshop):
        plans.append(plan)
        evaluated.append(corpora)
        return {policy: result(2.0, in_depth=policy in plan.in_depth) for policy in models}, SIZES

    monkeypatch.setattr(bench_sera, "_run", run)
    (tmp_path / "retrieval.json").write_text(json.dumps({"n": 5, "p95_ms": 1.0, "recall_at_10": 0.99}))
    base = ["sera", "--workers", "1", "--work", str(tmp_path / "work"), "--committed", str(tmp_path)]
    return base, plans, evaluated


def test_files_and_figures(command, tmp_path, capsys):
    base, plans, _ = command
    assert main([*base, "--policies", "neural,ego_mlp", "--seeds", "2", "--out", str(tmp_path / "out"), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert plans[0].seeds == 2
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == [
        "sera-tables.md",
        "sera.html",
        "sera.json",
        "sera.md",
    ]
    assert told == json.loads((tmp_path / "out" / "sera.json").read_text())
    assert set(told["summary"]) == {"neural", "ego_mlp"}
    assert told["comparisons"]["neural"]["in_order"]
    assert told["comparisons"]["neural"]["gain_percent"] == pytest.approx(100.0 * (66.65 / 60.5 - 1.0))
    assert "half_bank" not in told["summary"]["ego_mlp"]
    assert set(told["sweep"]) == {"neural"}
    assert told["retrieval"]["n"] == 5
    assert told["provenance"]["command"] == "./roadmend bench sera --policies neural,ego_mlp --seeds 2"


def test_a_repaired_replay_is_asked_for_in_the_plan_and_written_under_a_name_of_its_own(command, tmp_path, capsys):
    base, plans, _ = command
    assert main([*base, "--repaired-replay", "--no-in-depth", "--out", str(tmp_path / "out"), "--json"]) == 0
    assert plans[0].few_shot == {"replay_repair": True}
    assert (tmp_path / "out" / "sera-repaired-replay.md").exists()
    made = json.loads(capsys.readouterr().out)["provenance"]["command"]
    assert made == "./roadmend bench sera --no-in-depth --repaired-replay"


def test_a_quick_run_takes_less_and_writes_under_another_name(command, tmp_path, capsys):
    base, plans, _ = command
    assert main([*base, "--quick", "--out", str(tmp_path / "out")]) == 0
    assert plans[0].bank.violations < 20
    assert (tmp_path / "out" / "sera-quick.json").is_file()
    assert "full, half the bank" in capsys.readouterr().out


def test_half_the_bank_and_the_sweep_can_be_left_out(command, tmp_path, capsys):
    base, *_ = command
    plan = tmp_path / "plan.yaml"
    plan.write_text((Path(__file__).parent / "sera.yaml").read_text())
    assert main([*base, "--policies", "neural", "--plan", str(plan), "--no-in-depth", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["sweep"] == {}
    assert "half_bank" not in told["summary"]["neural"]
    expected = f"./roadmend bench sera --policies neural --plan {plan} --no-in-depth"
    assert told["provenance"]["command"] == expected


def test_fresh_cases_take_the_place_of_the_corpus(command, tmp_path, monkeypatch):
    base, plans, evaluated = command
    asked = []

    def gathered(policy, seed, cases, work, workers, _progress):
        asked.append((policy, seed, cases, work, workers))
        return "fresh"

    monkeypatch.setattr(bench_sera, "fresh_cases", gathered)
    arguments = ["--policies", "neural", "--fresh-seed", "7", "--cases", "3", "--no-in-depth", "--json"]
    assert main([*base, *arguments, "--out", str(tmp_path / "out")]) == 0
    assert asked == [("modular", 7, 3, tmp_path / "work", 1)]
    assert evaluated == [["fresh"]]
    assert (plans[0].evaluation.split, plans[0].evaluation.violations) == ("test", 3)
    told = json.loads((tmp_path / "out" / "sera-fresh-7.json").read_text())
    assert told["provenance"]["command"] == (
        "./roadmend bench sera --policies neural --fresh-seed 7 --cases 3 --no-in-depth"
    )
    assert "violations from searches with seed 7" in (tmp_path / "out" / "sera-fresh-7.md").read_text()


def test_a_plan_may_put_settings_in_the_place_of_the_shipped_ones():
    config = Path(__file__).parents[2] / "config"
    plan = read_sera_plan(Path(__file__).parent / "sera.yaml")
    shipped = read_few_shot_settings(config / "training" / "few-shot.yaml")
    assert bench_sera._few_shot(plan, config) == shipped
    less = plan.model_copy(update={"few_shot": {"replay": 2}})
    assert bench_sera._few_shot(less, config) == shipped.model_copy(update={"replay": 2})
    with pytest.raises(InputError, match="few_shot: field replay"):
        bench_sera._few_shot(plan.model_copy(update={"few_shot": {"replay": -2}}), config)


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (["--policies", "nobody"], "ships no nobody"),
        (["--plan", "gone.yaml"], "no such file"),
        (["--fresh-seed", "7"], "--fresh-seed and --cases go together"),
        (["--cases", "7"], "--fresh-seed and --cases go together"),
    ],
)
def test_mistakes_are_one_line(command, more, message, capsys):
    assert main([*command[0], *more]) == 2
    assert message in capsys.readouterr().err
