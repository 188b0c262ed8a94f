"""'roadmend train adreft' in the simulation, for a policy that sees nobody: it learns to save it, and resumes exactly."""

import importlib
import sys
from dataclasses import asdict
from types import SimpleNamespace

import numpy as np
import pytest
import yaml

from roadmend.cli.main import main
from roadmend.networks.checkpoint import find_model, load_checkpoint
from roadmend.policies.registry import POLICIES
from roadmend.repair.adreft.model import AdreftModel
from roadmend.repair.adreft.weighing import Weighing
from roadmend.training.adreft import pipeline
from roadmend.training.adreft.calibration import monitor_quality
from roadmend.training.adreft.configuration import PracticeSection, TrainingConfiguration
from roadmend.training.adreft.futures_practice import FuturesPractice
from roadmend.training.adreft.network import AdreftNetwork, save_model
from roadmend.training.adreft.pipeline import Pipeline
from roadmend.training.adreft.rollouts_tuning import RolloutsTuning
from roadmend.training.adreft.stage import RepairedPolicy, TrainingSubject
from roadmend.training.closed_loop import evaluate_cases, summarise
from roadmend.training.torch_state import tensors_of
from roadmend.world import corpus as corpus_module
from roadmend.world.corpus import save_corpus
from roadmend.world.families import FAMILIES

from .blind import ENTRY, blind_corpus
from .cases import Drawn

SMALL = {"tokenizer": "paper", "hidden": 32, "layers": 1, "feed_forward": 32, "monitor": [32], "adapter": [32]}
LEARNING = {
    "model": SMALL,
    "frames": {"stride": 2, "validation_stride": 2},
    "supervised": {"epochs": 12, "learning_rate": 3e-3, "batch": 64, "critical_share": 0.4, "clip": 1.0},
}
QUICK = {
    "model": SMALL,
    "frames": {"stride": 4, "validation_stride": 4},
    "supervised": {"epochs": 3, "learning_rate": 3e-3, "batch": 64},
    "reinforcement": {
        "episodes": 4,
        "round": 2,
        "warm_up": 20,
        "validate_every": 2,
        "learning_rate": 1e-3,
        "updates_per_step": 0.1,
    },
}


PRACTISED = {
    "model": {**SMALL, "tokenizer": "rich", "interval": 4},
    "frames": {"validation_stride": 4},
    "practice": {
        "epochs": 2,
        "monte_carlo_epochs": 1,
        "rounds": 2,
        "later_epochs": 1,
        "per_violation": 1,
        "per_success": 0,
        "blinded": 0,
        "batch": 64,
    },
    "reinforcement": {"episodes": 0},
}
FUTURES = {
    "model": {**SMALL, "tokenizer": "rich", "interval": 12, "hold": 0.6, "fresh": True, "weighing": {}},
    "frames": {"validation_stride": 4},
    "practice": {"method": "futures", "epochs": 2, "rounds": 2, "later_epochs": 1, "batch": 64},
    "futures": {
        "moments": 2,
        "futures": 2,
        "actions": 1,
        "harmless": 0.2,
        "random_cases": 0,
        "random_validation": 1,
        "touched": 0.5,
    },
    "reinforcement": {"episodes": 0},
}
_FORESEEING = ["--set", "model.weighing={}", "--set", "practice.method=counterfactual"]


CHOOSING = ("roadmend.cli.train", "roadmend.cli.driver_options")  # read the choices of --policy when imported


@pytest.fixture
def train(tmp_path, monkeypatch):
    """Runs the command for the blind policy in this process; returns its exit code."""
    monkeypatch.setitem(POLICIES, "blind", ENTRY)
    monkeypatch.setitem(POLICIES, "sleepy", ENTRY)
    for name in CHOOSING:
        monkeypatch.delitem(sys.modules, name, raising=False)
    importlib.import_module("roadmend.cli.train")

    def run(corpus, configuration, out, *options):
        save_corpus(corpus, tmp_path / "corpus.jsonl")
        (tmp_path / "config.yaml").write_text(yaml.safe_dump(configuration))
        files = ["--corpus", str(tmp_path / "corpus.jsonl"), "--config", str(tmp_path / "config.yaml")]
        fixed = ["--policy", "blind", "--workers", "1", "--device", "cpu"]
        return main(["train", "adreft", *fixed, *files, "--out", str(tmp_path / out), *options])

    yield run
    for name in CHOOSING:
        sys.modules.pop(name, None)


@pytest.mark.slow
def test_a_tiny_budget_saves_some_of_those_that_would_collide(train, tmp_path, capsys):
    corpus = blind_corpus(16, 4)
    assert train(corpus, LEARNING, "model.safetensors", "--only", "supervised") == 0
    assert "dE " in capsys.readouterr().out
    cases = corpus.select(split="validation")
    before = summarise(evaluate_cases(cases, "blind", "none"))
    after = summarise(evaluate_cases(cases, "blind", "adreft", {"model": str(tmp_path / "model.safetensors")}))
    assert (before.violations, before.successes) == (4, 4)
    assert before.delta_e == before.fix_loose == 0.0
    assert after.delta_e > 20.0
    metrics = load_checkpoint(tmp_path / "model.safetensors").header["metrics"]
    assert metrics["validation"] == after.as_dict()
    assert metrics["monitor"]["recall"] > 0.95


@pytest.mark.slow
def test_foreseen_collisions_save_some_too(train, tmp_path):
    corpus = blind_corpus(5, 3)
    practice = {
        "method": "counterfactual",
        "epochs": 12,
        "per_violation": 3,
        "per_success": 1,
        "gentle_per_violation": 2,
        "blinded": 0,
        "batch": 64,
        "learning_rate": 3e-3,
    }
    foreseeing = {**PRACTISED, "practice": practice}
    foreseeing["model"] = {**PRACTISED["model"], "weighing": {"strength": 0.4}}
    assert train(corpus, foreseeing, "model.safetensors") == 0
    assert AdreftModel.load(tmp_path / "model.safetensors").configuration.weighing is not None
    after = evaluate_cases(
        corpus.select(split="validation"), "blind", "adreft", {"model": str(tmp_path / "model.safetensors")}
    )
    assert summarise(after).delta_e > 20.0


def test_the_stages_apart_give_the_same_bits_as_together(train, tmp_path, capsys):
    corpus = blind_corpus(2, 1)
    assert train(corpus, QUICK, "whole.safetensors") == 0
    assert train(corpus, QUICK, "pieces.safetensors", "--only", "supervised") == 0
    supervised = (tmp_path / "pieces.safetensors").read_bytes()
    assert train(corpus, QUICK, "pieces.safetensors") == 2
    assert "holds a training already; go on with --resume" in capsys.readouterr().err.splitlines()[-1]
    assert (tmp_path / "pieces.safetensors").read_bytes() == supervised
    assert train(corpus, QUICK, "pieces.safetensors", "--resume") == 0
    whole = (tmp_path / "whole.safetensors").read_bytes()
    assert (tmp_path / "pieces.safetensors").read_bytes() == whole != supervised
    assert train(corpus, QUICK, "pieces.safetensors", "--restart", "--seed", "1", "--only", "supervised") == 0
    assert (tmp_path / "pieces.safetensors").read_bytes() not in (whole, supervised)
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "config.yaml",
        "corpus.jsonl",
        "pieces.safetensors",
        "pieces.training",
        "whole.safetensors",
        "whole.training",
    ]
    header = load_checkpoint(tmp_path / "whole.safetensors", "adreft").header
    assert header["data"]["corpus"] == corpus.digest
    assert header["configuration"]["training"]["reinforcement"]["episodes"] == 4
    assert header["metrics"]["reinforcement"]["episodes"] == 4

    assert (
        train(
            corpus, QUICK, "tuned.safetensors", "--start", str(tmp_path / "pieces.safetensors"), "--only", "supervised"
        )
        == 0
    )
    tuned = load_checkpoint(tmp_path / "tuned.safetensors")
    assert tuned.header["ancestry"] == [AdreftModel.load(tmp_path / "pieces.safetensors").digest]


def test_rounds_of_practice_go_on_where_they_stood(train, tmp_path):
    corpus = blind_corpus(2, 1)
    assert train(corpus, PRACTISED, "whole.safetensors") == 0
    whole = (tmp_path / "whole.safetensors").read_bytes()
    work = tmp_path / "whole.training"
    guide, last = work / "guide-1.safetensors", work / "practice-1.safetensors"
    assert len(list((work / "trials").iterdir())) == 2 * len(corpus.select(split="training"))
    before = last.read_bytes()
    assert train(corpus, PRACTISED, "whole.safetensors") == 2
    last.unlink()
    guide.unlink()
    (tmp_path / "whole.safetensors").unlink()
    assert train(corpus, PRACTISED, "whole.safetensors", "--resume") == 0
    assert (tmp_path / "whole.safetensors").read_bytes() == whole
    assert last.read_bytes() == before
    assert AdreftModel.load(guide).digest != AdreftModel.load(tmp_path / "whole.safetensors").digest


def test_the_trials_of_another_policy_can_be_practised_on_too(train, tmp_path, monkeypatch):
    corpus = blind_corpus(1, 1)
    other = type(corpus)("sleepy", blind_corpus(2, 1).cases)
    monkeypatch.setattr(corpus_module, "config_folder", lambda: tmp_path / "config")
    save_corpus(other, tmp_path / "config" / "corpora" / "sleepy.jsonl")
    once = {**PRACTISED, "practice": {**PRACTISED["practice"], "rounds": 1}}
    assert train(corpus, once, "alone.safetensors") == 0
    assert train(corpus, once, "both.safetensors", "--also", "sleepy", "--set", "practice.dose=0.5") == 0
    alone, both = (load_checkpoint(tmp_path / f"{name}.safetensors").header for name in ("alone", "both"))
    assert alone["data"]["also"] == []
    assert [(each["name"], each["corpus"]) for each in both["data"]["also"]] == [("sleepy", other.digest)]
    assert alone["data_digest"] != both["data_digest"]
    doses = [each["configuration"]["training"]["practice"]["dose"] for each in (alone, both)]
    assert doses == [PracticeSection().dose, 0.5]
    assert alone["data"]["training"] == both["data"]["training"]
    count = len(list((tmp_path / "both.training" / "trials").iterdir()))
    assert count == len(corpus.select(split="training")) + len(other.select(split="training"))


@pytest.mark.slow
def test_practice_on_futures_goes_on_where_it_stood_and_says_how_reliable_its_monitor_is(train, tmp_path, capsys):
    corpus = blind_corpus(1, 1)
    assert train(corpus, FUTURES, "whole.safetensors") == 0
    path, work = tmp_path / "whole.safetensors", tmp_path / "whole.training"
    whole, model = path.read_bytes(), AdreftModel.load(path)
    moments = sorted((work / "moments").iterdir())
    assert len(moments) == 2 * 2 + 2 + len(FAMILIES)  # two rounds of the training cases, and those for validation
    guide, last = work / "futures-guide-1.safetensors", work / "practice-1.safetensors"
    assert AdreftModel.load(guide).digest != model.digest
    for gone in (last, guide, path, moments[0]):
        gone.unlink()
    assert train(corpus, FUTURES, "whole.safetensors") == 2
    assert train(corpus, FUTURES, "whole.safetensors", "--resume") == 0
    assert path.read_bytes() == whole
    metrics = load_checkpoint(path).header["metrics"]
    told = metrics["futures"]
    assert 0.0 <= told["calibration_error"] <= 1.0
    assert 0.0 < told["rate"] < 1.0
    assert sum(each["weight"] for each in told["bins"]) == pytest.approx(1.0)
    assert {"precision", "recall", "f1"} == set(metrics["monitor"])
    capsys.readouterr()

    on = ["--set", f"futures.start={path}", "--set", "practice.rounds=1", "--set", "practice.epochs=1"]
    assert train(corpus, FUTURES, "on.safetensors", "--work", str(work), "--restart", *on) == 0
    header = load_checkpoint(tmp_path / "on.safetensors").header
    assert header["ancestry"] == [model.digest]
    assert train(corpus, FUTURES, "other.safetensors", *on, "--set", "model.adapter=[8]") == 2
    assert "has other networks than the configuration asks for" in capsys.readouterr().err


@pytest.mark.slow
def test_fine_tuning_by_rollouts_goes_on_from_a_model_and_moves_its_adapter_alone(train, tmp_path):
    corpus = blind_corpus(2, 1)
    assert train(corpus, FUTURES, "before.safetensors", "--set", "practice.rounds=1") == 0
    rollouts = {"rounds": 2, "moments": 2, "futures": 2, "actions": 1, "random_cases": 0, "epochs": 3, "score": 0.0}
    tuning = {**FUTURES, "rollouts": {**rollouts, "held_out": 0.5, "learning_rate": 0.01}}
    start = ["--start", str(tmp_path / "before.safetensors"), "--work", str(tmp_path / "before.training"), "--restart"]
    assert train(corpus, tuning, "after.safetensors", *start) == 0
    after = (tmp_path / "after.safetensors").read_bytes()
    kept = list((tmp_path / "before.training" / "rollouts").iterdir())
    assert len(kept) == 2 * len(corpus.select(split="training"))
    kept[0].unlink()
    assert train(corpus, tuning, "after.safetensors", *start) == 0
    assert (tmp_path / "after.safetensors").read_bytes() == after
    first, second = (load_checkpoint(tmp_path / f"{name}.safetensors") for name in ("before", "after"))
    told = second.header["metrics"]["rollouts"]
    assert len(told) == 2
    assert 0 < told[0]["moments"] < told[1]["moments"]
    assert second.header["ancestry"] == [first.digest]
    assert first.header["metrics"]["rollouts"] == []
    moved = {name.split(".")[0] for name in first.tensors if (first.tensors[name] != second.tensors[name]).any()}
    assert moved <= {"adapter"}


def test_the_monitor_is_told_of_at_the_threshold_that_the_model_gets(tmp_path, monkeypatch):
    configuration = TrainingConfiguration.model_validate({**FUTURES, "rollouts": {"rounds": 1}})
    model, start = configuration.model.configuration(), tmp_path / "start.safetensors"
    first = save_model(start, model, tensors_of(AdreftNetwork(model)), 0.5, ancestry=["its parent"])
    scores, critical = np.array([0.6, 0.3, 0.3, 0.1]), np.array([1.0, 1.0, 0.0, 0.0])
    frames = SimpleNamespace(critical=critical, critical_weight=np.ones(4), action=np.zeros(4))
    monkeypatch.setattr(Pipeline, "_frames", lambda *_: frames)
    monkeypatch.setattr(Pipeline, "_look", lambda *_: [])
    monkeypatch.setattr(FuturesPractice, "calibrate", lambda _self, _networks, touched=None: 0.2 if touched else 0.5)
    monkeypatch.setattr(FuturesPractice, "judge", lambda *_: {})
    monkeypatch.setattr(RolloutsTuning, "run", lambda _self, networks, _threshold: (networks, []))
    monkeypatch.setattr(pipeline, "monitor_scores", lambda *_: scores)
    cases = (Drawn("S3", 1, is_violation=True), Drawn("S3", 2))
    subject = TrainingSubject(RepairedPolicy("blind", "", "", cases), cases)
    training = Pipeline(configuration, subject, seed=0, device="cpu", mapper=map, work=tmp_path)
    trained = training.run(tmp_path / "out.safetensors", start=start)
    assert trained.threshold == 0.2
    assert trained.monitor == monitor_quality(scores, critical > 0.5, 0.2)
    assert trained.monitor != monitor_quality(scores, critical > 0.5, 0.5)
    header = load_checkpoint(tmp_path / "out.safetensors").header
    assert header["metrics"]["monitor"] == asdict(trained.monitor)
    assert header["ancestry"] == [first, "its parent"]
    assert header["configuration"]["device"] == "cpu"


def test_without_precaution_only_the_monitor_decides(train, tmp_path):
    corpus = blind_corpus(1, 1)
    practice = {**PRACTISED["practice"], "rounds": 1, "method": "counterfactual"}
    prices = {"strength": 0.3, "gain": 0.2}
    foreseeing = {**PRACTISED, "practice": practice, "model": {**PRACTISED["model"], "weighing": prices}}
    assert train(corpus, foreseeing, "with.safetensors") == 0
    reacting = {**foreseeing, "model": {**PRACTISED["model"], "weighing": {**prices, "gain": 0.0}}}
    assert train(corpus, reacting, "without.safetensors", "--start", str(tmp_path / "with.safetensors")) == 0
    both, alone = (AdreftModel.load(tmp_path / f"{name}.safetensors") for name in ("with", "without"))
    assert both.configuration.weighing.model_dump() == Weighing(**prices).model_dump()
    assert alone.configuration.weighing == both.configuration.weighing.model_copy(update={"gain": 0.0})
    assert alone.threshold == both.threshold


@pytest.mark.parametrize("ablation", ["rand_r", "only_rl", "wo_sr", "wo_regulation"])
def test_ablations_leave_something_out(train, tmp_path, ablation):
    corpus = blind_corpus(1, 1)
    quick = {
        **QUICK,
        "supervised": {"epochs": 1},
        "reinforcement": {**QUICK["reinforcement"], "episodes": 2, "keep": "last"},
    }
    assert train(corpus, quick, "model.safetensors", "--ablation", ablation) == 0
    model = AdreftModel.load(tmp_path / "model.safetensors")
    made = load_checkpoint(tmp_path / "model.safetensors").header["configuration"]
    assert (model.configuration.choice == "random") == (ablation == "rand_r") == (made["only"] == "supervised")
    assert (made["training"]["reinforcement"]["start"] == "scratch") == (ablation == "only_rl")
    assert made["training"]["reinforcement"]["step_reward"] == (ablation != "wo_sr")
    assert (made["training"]["frames"]["labels"] == "weak") == (ablation != "wo_regulation")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--only", "reinforcement"], "there is no supervised stage to begin with"),
        (
            ["--only", "reinforcement", "--set", "reinforcement.episodes=0"],
            "--only: this configuration has no fine-tuning",
        ),
        (["--start", "none.safetensors"], "none.safetensors: no such file"),
        (["--device", "abacus"], "'abacus' cannot be used here"),
        (["--also", "sleepy"], "nothing is practised by this configuration"),
        (["--set", "practice.dose"], "'practice.dose' is no SECTION.NAME=VALUE; write for instance"),
        (["--set", "practice=1"], "'practice=1' is no SECTION.NAME=VALUE"),
        (["--set", "practice.dose=much"], "practice.dose"),
        (["--set", "practise.dose=1"], "practise"),
        (["--set", "practice.epochs=1", "--set", "practice.method=counterfactual"], "model.weighing: does not go with"),
        (["--set", "model.weighing={}"], "model.weighing: does not go with practice.method"),
        (
            [*_FORESEEING, "--set", "practice.epochs=1", "--set", "practice.rounds=2"],
            "practice.rounds: counterfactuals",
        ),
        (["--set", "practice.epochs=1", "--set", "practice.method=futures"], "model.weighing: does not go with"),
        ([*_FORESEEING, "--set", "practice.epochs=1"], "reinforcement.episodes: a DQN takes an adapter that"),
        (["--set", "rollouts.rounds=1"], "rollouts.rounds: rollouts take an adapter that foresees"),
        (["--ablation", "wo_sr", "--set", "reinforcement.episodes=0"], "--ablation: 'wo_sr' changes fine-tuning, of"),
    ],
)
def test_what_cannot_be_is_said_in_one_line(train, tmp_path, capsys, options, words):
    assert train(blind_corpus(1, 1), QUICK, "model.safetensors", *options) == 2
    assert words in capsys.readouterr().err.splitlines()[-1]
    assert not (tmp_path / "model.safetensors").exists()


def test_fine_tuning_alone_begins_with_what_an_earlier_call_has_practised(train, tmp_path, capsys):
    options = ["--only", "reinforcement", "--set", "reinforcement.episodes=2"]
    assert train(blind_corpus(1, 1), PRACTISED, "model.safetensors", *options) == 2
    assert "practice-1.safetensors: there is no supervised stage to begin with" in capsys.readouterr().err
    assert not [*(tmp_path / "model.training").iterdir()]  # nobody has driven


def test_of_a_model_to_begin_with_it_is_said_what_is_left_out(train, tmp_path, capsys):
    start = find_model("modular", "adreft-")
    assert train(blind_corpus(1, 1), QUICK, "model.safetensors", "--start", str(start)) == 2  # has other networks
    assert f"{start}: its need and change monitors are left out" in capsys.readouterr().err


def test_a_model_that_cannot_be_leaves_no_folder(train, tmp_path, capsys):
    assert train(blind_corpus(1, 1), QUICK, "model.safetensors", "--set", "model.pressing=0.15") == 2
    assert "pressing: needs a model with a need monitor" in capsys.readouterr().err
    assert not (tmp_path / "model.training").exists()


def test_a_corpus_without_violations_or_of_another_policy_is_refused(train, tmp_path, capsys):
    corpus = blind_corpus(1, 1)
    harmless = type(corpus)("blind", tuple(case for case in corpus.cases if not case.is_violation))
    assert train(harmless, QUICK, "model.safetensors") == 2
    assert "training split: holds no violation" in capsys.readouterr().err
    assert train(type(corpus)("modular", corpus.cases), QUICK, "model.safetensors") == 2
    assert "is a corpus of the policy 'modular'" in capsys.readouterr().err
    assert train(corpus, PRACTISED, "model.safetensors", "--also", "blind") == 2
    assert "--also: 'blind' is the policy itself" in capsys.readouterr().err
