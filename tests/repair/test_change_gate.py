"""Lane changes are held back where the change monitor sees a risk, and nowhere else."""

import numpy as np
import pytest

from roadmend.core.command import Command, Decision
from roadmend.core.errors import InputError
from roadmend.core.repair import RepairStatus
from roadmend.networks.checkpoint import load_checkpoint, save_checkpoint
from roadmend.networks.compiled_encoder import CompiledEncoder, CompiledHead, sigmoid
from roadmend.repair.adreft import risk_monitor
from roadmend.repair.adreft.model import AdreftModel
from roadmend.repair.registry import make_repairer

from .playground import Box, keep_on, scene_of, straight_route
from .tiny_model import RISK, configuration_of, header_of, random_tensors, save_tiny_model

SCENE = scene_of([Box(1, 12.0, 3.5), Box(2, -9.0, 3.5)])


@pytest.fixture
def model(tmp_path):
    return save_tiny_model(tmp_path / "tiny.safetensors", threshold=1.0, change=RISK)


def asking(*, change_lane=True):
    decision = keep_on(SCENE, action=0.3)
    return Decision(Command.from_action(0.3, change_lane=change_lane), decision.trajectory)


def answer(method, model, decision=None, **parameters):
    repairer = make_repairer(method, {"model": str(model), **parameters})
    repairer.reset(straight_route())
    return repairer.step(SCENE, decision or asking())


def risk_by_hand(model):
    checkpoint, configuration = load_checkpoint(model), configuration_of(change=RISK).change
    encoder = CompiledEncoder(configuration.encoder, checkpoint.tensors, "change.encoder.")
    head = CompiledHead(configuration.head_shape, checkpoint.tensors, "change.head.")
    tokenizer = AdreftModel.load(model).tokenizer()
    return sigmoid(float(head.apply(encoder.encode(tokenizer.tokens(SCENE, asking()).values))[0]))


@pytest.mark.parametrize("method", ["adreft", "gated"])
def test_a_change_waits_where_its_risk_is_above_the_threshold(model, method):
    risk = risk_by_hand(model)
    held = answer(method, model, change_threshold=risk - 1e-6)
    assert held.held_back
    assert held.intervened
    assert not held.command.change_lane
    assert held.final_action == pytest.approx(0.3)  # no pedal moves for it
    assert held.change == 0.0
    assert f"lane change held back: risk {risk:.3f}" in held.reason
    assert held.triggers
    assert {trigger.object_id for trigger in held.triggers} <= {1, 2}
    let_through = answer(method, model, change_threshold=risk + 1e-6)
    assert let_through.command.change_lane
    assert not let_through.held_back
    assert not let_through.intervened


def test_the_threshold_is_the_models_own_unless_one_is_given_and_1_is_never(model):
    assert answer("adreft", model).held_back == (risk_by_hand(model) > RISK["threshold"])
    assert answer("adreft", model, change_threshold=0.0).held_back
    assert not answer("adreft", model, change_threshold=1.0).held_back


def test_nothing_is_held_back_that_nobody_asked_for(model):
    answered = answer("adreft", model, asking(change_lane=False), change_threshold=0.0)
    assert not answered.held_back
    assert not answered.intervened


def test_a_model_without_change_monitor_lets_every_change_through(tmp_path):
    plain = save_tiny_model(tmp_path / "plain.safetensors", threshold=1.0)
    assert answer("adreft", plain, change_threshold=0.0).command.change_lane


def test_a_monitor_that_fails_is_a_fault_of_the_model(model, monkeypatch):

    monkeypatch.setattr(risk_monitor, "sigmoid", lambda _logit: np.nan)
    repair = answer("adreft", model)
    assert repair.status is RepairStatus.MODEL_FAULT
    assert repair.held_back  # no lane change begins that nobody judges


def test_a_monitor_whose_tensors_are_missing_is_refused(tmp_path):
    configuration = configuration_of(change=RISK)
    tensors = {name: value for name, value in random_tensors(configuration).items() if "change.head" not in name}
    path = tmp_path / "short.safetensors"
    save_checkpoint(path, tensors, header_of(configuration, 1.0))
    with pytest.raises(InputError, match=r"change\.head"):
        AdreftModel.load(path)
