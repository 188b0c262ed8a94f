"""An intervention begins where the need monitor foresees a collision; how long it lasts is the score's affair."""

import numpy as np
import pytest

from roadmend.repair.actions import ACTIONS
from roadmend.repair.adreft.model import AdreftModel
from roadmend.repair.adreft.need_gate import NEVER, NeedGate
from roadmend.repair.adreft.risk_monitor import RiskMonitor
from roadmend.repair.adreft.tokenizer import TokenSet
from roadmend.repair.registry import make_repairer

from .playground import Box, keep_on, scene_of, straight_route
from .tiny_model import RISK, save_tiny_model

TOKENS = TokenSet(np.zeros((1, 6), dtype=np.float32), np.array([-1], dtype=np.int32))
SCENE = scene_of([Box(1, 12.0, 0.0, speed=0.0)])


def asked(gate, score, threshold, bar):
    gate.see(SCENE, keep_on(SCENE), TOKENS)
    return gate.bar(score, threshold, bar)


@pytest.fixture
def file(tmp_path):
    return save_tiny_model(tmp_path / "tiny.safetensors", threshold=0.0, need=RISK)


@pytest.fixture
def gate(file, monkeypatch):
    """A gate at 0.5 and the risks that its monitor gives from now on."""
    risks = []
    monkeypatch.setattr(RiskMonitor, "risk", lambda _monitor, _tokens: risks.pop(0))
    made = NeedGate(AdreftModel.load(file), -1.0)
    made.reset()
    return made, risks


def test_what_is_not_needed_does_not_begin(gate):
    made, risks = gate
    risks += [0.2, 0.5, 0.6]
    assert asked(made, 0.9, 0.4, 0.4)[0] == NEVER
    bar, reason = asked(made, 0.9, 0.4, 0.4)
    assert bar == NEVER
    assert reason == "criticality 0.900, but not needed: risk 0.500 not above 0.500"
    assert asked(made, 0.9, 0.4, 0.4) == (0.4, "")
    assert not risks


def test_what_has_begun_is_not_asked_again_until_it_has_ended(gate):
    made, risks = gate
    risks += [0.6, 0.1]
    assert asked(made, 0.9, 0.4, 0.4)[0] == 0.4
    assert asked(made, 0.5, 0.4, 0.7)[0] == 0.7  # patience has raised the bar: that is no end
    assert asked(made, 0.8, 0.4, 0.7)[0] == 0.7
    assert asked(made, 0.4, 0.4, 0.4)[0] == 0.4
    assert asked(made, 0.9, 0.4, 0.4)[0] == NEVER
    made.reset()
    risks.append(0.9)
    assert asked(made, 0.9, 0.4, 0.4)[0] == 0.4


def test_who_is_not_critical_is_not_asked_about(gate):
    made, risks = gate
    assert asked(made, 0.3, 0.4, 0.4) == (0.4, "")
    assert not risks


def pressed(tmp_path, monkeypatch, pressing, risks):
    monkeypatch.setattr(RiskMonitor, "risk", lambda _monitor, _tokens: risks.pop(0))
    path = save_tiny_model(tmp_path / "tiny.safetensors", threshold=0.0, need=RISK, pressing=pressing)
    return NeedGate(AdreftModel.load(path), -1.0)


def test_a_risk_that_stays_high_calls_for_full_braking_and_is_worked_out_once_a_tick(tmp_path, monkeypatch):
    risks = [0.6, 0.3, 0.2, 0.9]
    made = pressed(tmp_path, monkeypatch, 0.25, risks)
    found = []
    for _ in range(4):
        assert asked(made, 0.9, 0.4, 0.4) == (0.4, "")
        found.append(made.pressing_risk())
    assert found == [0.6, 0.3, None, 0.9]
    assert not risks


def test_without_a_pressing_risk_or_a_need_monitor_the_adapter_chooses(tmp_path, monkeypatch):
    made = pressed(tmp_path, monkeypatch, 0.0, [0.9])
    asked(made, 0.9, 0.4, 0.4)
    assert made.pressing_risk() is None
    plain = NeedGate(AdreftModel.load(save_tiny_model(tmp_path / "plain.safetensors")), -1.0)
    asked(plain, 0.9, 0.4, 0.4)
    assert plain.pressing_risk() is None


@pytest.mark.parametrize(("risk", "action"), [(0.3, -1.0), (0.1, -0.6)])
def test_an_intervention_brakes_in_full_as_long_as_the_risk_presses(tmp_path, monkeypatch, risk, action):
    monkeypatch.setattr(RiskMonitor, "risk", lambda _monitor, _tokens: risk)
    values = np.eye(1, len(ACTIONS), ACTIONS.index(-0.6), dtype=np.float32)[0]
    monkeypatch.setattr(AdreftModel, "values", lambda *_: values)
    path = save_tiny_model(tmp_path / "tiny.safetensors", threshold=0.0, need=RISK, pressing=0.2)
    repairer = make_repairer("adreft", {"model": str(path), "need_threshold": 0.05})
    repairer.reset(straight_route())
    repair = repairer.step(SCENE, keep_on(SCENE, action=0.3))
    assert repair.final_action == action
    assert ("braking in full: risk 0.300" in repair.reason) == (action == -1.0)


@pytest.mark.parametrize("method", ["adreft", "gated"])
def test_a_repair_waits_until_it_is_needed(file, method, monkeypatch):
    def proposal(**parameters):
        repairer = make_repairer(method, {"model": str(file), **parameters})
        repairer.reset(straight_route())
        return repairer.step(SCENE, keep_on(SCENE, action=0.3))

    monkeypatch.setattr(RiskMonitor, "risk", lambda _monitor, _tokens: 0.3)
    waits = proposal()
    assert waits.threshold == NEVER
    assert not waits.intervened
    assert "not needed: risk 0.300" in waits.reason
    assert proposal(need_threshold=0.2).threshold == 0.0
    assert proposal(need_threshold=0.0).threshold == 0.0


def test_a_model_without_need_monitor_needs_every_intervention(tmp_path):
    made = NeedGate(AdreftModel.load(save_tiny_model(tmp_path / "plain.safetensors")), 0.9)
    assert asked(made, 0.9, 0.4, 0.4) == (0.4, "")
