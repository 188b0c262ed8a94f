"""Where an intervention would begin, and what comes of it if nobody steps in."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from roadmend.cli.main import main
from roadmend.core.repair import RepairStatus
from roadmend.networks.checkpoint import find_model, load_checkpoint
from roadmend.policies.registry import make_policy
from roadmend.repair.adreft.history import ATTRIBUTES
from roadmend.repair.adreft.model import AdreftModel
from roadmend.repair.registry import make_repairer
from roadmend.training.adreft.case_risks import RiskPlan
from roadmend.training.adreft.gathering import Recipe
from roadmend.training.adreft.need_drives import LOWEST, needs_of_case
from roadmend.training.adreft.risk_training import KINDS, model_beside
from roadmend.world.corpus import corpus_of, save_corpus
from roadmend.world.runner import run_episode

from .cases import Drawn

SHIPPED = find_model("modular", "adreft-")
MODEL = AdreftModel.load(SHIPPED)


def found_of(case, *, plain=False, drives=1, history=False):
    plan = RiskPlan("modular", "x", drives, 8.0, plain=plain, history=history, seed=0)
    return needs_of_case(case, Recipe("modular", MODEL.configuration.tokenizer, 1), plan)


def violation():
    return corpus_of("modular").select("S3", "training", violation=True)[0]


def test_critical_ticks_of_a_drive_that_ends_badly_are_kept_and_said_to():
    found = found_of(violation())
    assert found.tokens.shape[0] == found.counts.sum()
    assert len(found) > 3
    assert found.collided[-1] == 1.0
    first = found.tokens[: found.counts[0]].astype(np.float32)
    action = 0.0  # half precision moves the score a little, and so does the action
    assert MODEL.score(MODEL.encode(first), action) > 0.1 * LOWEST


def test_of_a_plain_drive_every_critical_tick_is_kept_else_a_third():
    case = violation()
    assert len(found_of(case)) < 0.5 * len(found_of(case, plain=True))


def test_worlds_that_differ_are_driven_of_what_a_search_has_found_alone():
    case = violation()
    assert len(found_of(case, drives=2)) > len(found_of(case))
    drawn = Drawn("S3", 3)
    assert len(found_of(drawn, drives=2)) == len(found_of(drawn))


def test_the_last_second_and_the_drive_so_far_are_kept_with_a_tick():
    plain, told = (found_of(violation(), history=history) for history in (False, True))
    assert plain.counts.tolist() == told.counts.tolist()
    assert np.array_equal(plain.tokens, told.tokens[:, : plain.tokens.shape[1]])
    assert told.tokens.shape[1] == plain.tokens.shape[1] + ATTRIBUTES
    assert np.abs(told.tokens[:, plain.tokens.shape[1] :]).max(axis=0).min() > 0.0  # each column says something


def test_further_policies_are_looked_at_by_their_own_models():
    mine = Path("mine.safetensors")
    assert model_beside(KINDS["need"], "neural", mine, "rich") == find_model("neural", "adreft-")
    assert model_beside(KINDS["need"], "neural", mine, "paper") == mine  # its tokens and those of the other do not join
    assert model_beside(KINDS["need"], "ego_mlp", mine, "rich") == mine  # for which none ships
    assert model_beside(KINDS["changes"], "neural", mine, "rich") == mine  # it repairs those drives


@pytest.mark.parametrize("setting", ["families=[S9]", "families=[]", "head=[0]"])
def test_settings_that_cannot_be_learned_with_are_refused_before_anybody_drives(tmp_path, capsys, setting):
    words = ["train", "need", str(SHIPPED), "--policy", "modular", "--out", str(tmp_path / "x.safetensors")]
    assert main([*words, "--set", setting]) == 2
    [line] = capsys.readouterr().err.splitlines()
    assert setting.partition("=")[0] in line
    assert not [*tmp_path.iterdir()]


def test_a_model_gets_a_monitor_of_need(tmp_path, capsys):
    whole = corpus_of("modular")
    corpus, out = tmp_path / "modular.jsonl", tmp_path / "needed.safetensors"
    save_corpus(replace(whole, cases=tuple(whole.select("S3", "training", violation=True)[:3])), corpus)
    words = ["train", "need", str(SHIPPED), "--policy", "modular", "--out", str(out), "--json", "--workers", "2"]
    words += [word for each in ("random_cases=2", "validation_cases=4", "epochs=1") for word in ("--set", each)]
    words += ["--set", 'families=["S3"]', "--corpus", str(corpus), "--also", "ego_mlp"]
    assert main(words) == 0
    told = json.loads(capsys.readouterr().out)
    before, after = load_checkpoint(SHIPPED), load_checkpoint(out)
    assert after.header["need"]["threshold"] == told["threshold"]
    assert after.header["ancestry"][0] == before.digest
    assert {*after.header["need"]["drivers"]} == {"modular", "ego_mlp"}
    assert after.header["need"]["drivers"]["ego_mlp"]["corpus"] == ""  # none ships: its random drives alone
    kept = [name for name in before.tensors if not name.startswith("need.")]
    assert all(np.array_equal(before.tensors[name], after.tensors[name]) for name in kept)
    monitor = AdreftModel.load(out).need
    assert monitor is not None
    assert monitor.configuration.history
    repairer, states = make_repairer("adreft", {"model": str(out), "threshold": 0.0}), set()
    scenario, policy = violation().scenario(), make_policy("modular")
    run_episode(scenario, policy, repairer, lambda _tick, _decision, repair: states.add(repair.status))
    assert RepairStatus.MODEL_FAULT not in states
    first = out.read_bytes()
    assert main(words) == 0  # what was driven is read again
    assert out.read_bytes() == first


def test_a_history_needs_a_token_of_the_egos_own(tmp_path, capsys):
    paper = SHIPPED.parent / "ablations" / "adreft_paper-modular.safetensors"
    out = tmp_path / "needed.safetensors"
    assert main(["train", "need", str(paper), "--policy", "modular", "--out", str(out)]) == 2
    assert "has no token of the ego's own among 'paper'" in capsys.readouterr().err
    assert not [*tmp_path.iterdir()]
