"""The repair method adreft: what it proposes, whom it names, and which models it refuses."""

import json
from random import Random

import numpy as np
import pytest

from roadmend.core.errors import InputError
from roadmend.core.repair import RepairStatus
from roadmend.networks.checkpoint import load_checkpoint, save_checkpoint
from roadmend.networks.compiled_encoder import CompiledEncoder, CompiledHead, sigmoid
from roadmend.repair.actions import ACTIONS
from roadmend.repair.adreft.method import AdreftRepair
from roadmend.repair.adreft.model import AdreftModel
from roadmend.repair.adreft.registry import TOKENIZERS
from roadmend.repair.adreft.weighing import Weighing, gain_of
from roadmend.repair.parameters import AdreftParameters
from roadmend.repair.registry import make_repairer

from .playground import Box, keep_on, scene_of, straight_route
from .tiny_model import configuration_of, header_of, random_tensors, save_tiny_model


@pytest.fixture
def model(tmp_path):
    return save_tiny_model(tmp_path / "tiny.safetensors")


def crowd(seed, count):
    numbers = Random(seed)
    return scene_of([Box(10 + index, numbers.uniform(-40, 60), numbers.uniform(-9, 9)) for index in range(count)])


def made(path, **parameters):
    method = AdreftRepair(AdreftParameters(model=str(path), **parameters))
    method.reset(straight_route())
    return method


@pytest.mark.parametrize("count", [0, 1, 7, 60])
def test_the_proposal_is_what_the_networks_say(model, count):
    method, scene = made(model), crowd(count, count)
    proposal = method.propose(scene, keep_on(scene, action=0.3))
    checkpoint, configuration = load_checkpoint(model), configuration_of()
    encoder = CompiledEncoder(configuration.encoder, checkpoint.tensors, "encoder.")
    state = encoder.encode(method.model.tokenizer().tokens(scene, keep_on(scene)).values)
    seen = np.append(state, np.float32(0.3)).astype(np.float32)
    monitor = CompiledHead(configuration.monitor_shape, checkpoint.tensors, "monitor.")
    adapter = CompiledHead(configuration.adapter_shape, checkpoint.tensors, "adapter.")
    assert proposal.score == sigmoid(monitor.apply(seen)[0])
    assert proposal.threshold == 0.5
    assert proposal.action == ACTIONS[int(np.argmax(adapter.apply(state)))]


def test_a_choice_is_worth_its_gain_in_prices_of_a_collision(tmp_path):
    scene = crowd(3, 4)
    weighing = Weighing(collision=4.0, strength=0.0, any=0.0)
    method = made(save_tiny_model(tmp_path / "weighs.safetensors", weighing=weighing))
    proposal = method.propose(scene, keep_on(scene, action=0.9))
    tokens = method.model.tokenizer().tokens(scene, keep_on(scene, action=0.9)).values
    values = method.model.values(method.model.encode(tokens), 0.9)
    assert proposal.worth == gain_of(values, 0.9) / 4.0 > 0.0


def test_what_a_held_choice_is_worth_is_judged_anew(tmp_path):
    weighing = Weighing(collision=4.0, strength=0.0, any=0.0)
    path = save_tiny_model(tmp_path / "holds.safetensors", weighing=weighing, interval=2)
    method, first, second = made(path), crowd(3, 4), crowd(5, 2)
    chosen = method.propose(first, keep_on(first, action=0.9)).action
    held = method.propose(second, keep_on(second, action=0.9))
    assert held.action == chosen
    tokens = method.model.tokenizer().tokens(second, keep_on(second, action=0.9)).values
    values = method.model.values(method.model.encode(tokens), 0.9)
    assert held.worth == pytest.approx(gain_of(values, 0.9, ACTIONS.index(chosen)) / 4.0)


def test_an_adapter_that_foresees_nothing_judges_no_worth(model):
    scene = crowd(3, 4)
    assert made(model).propose(scene, keep_on(scene, action=0.9)).worth is None


def test_what_pays_is_due_before_the_monitor_alarms(tmp_path):
    scene = crowd(3, 4)

    def proposed(gain, threshold=0.999999, **parameters):
        weighing = Weighing(strength=0.0, any=0.0, gain=gain)
        path = save_tiny_model(tmp_path / f"{gain}.safetensors", threshold=threshold, weighing=weighing)
        method = made(path, **parameters)
        return method, method.propose(scene, keep_on(scene, action=0.9))

    method, alone = proposed(0.0)
    tokens = method.model.tokenizer().tokens(scene, keep_on(scene, action=0.9)).values
    worth = gain_of(method.model.values(method.model.encode(tokens), 0.9), 0.9)
    assert worth > 0.0
    assert alone.score == method.model.score(method.model.encode(tokens), 0.9) < alone.threshold
    assert (alone.triggers, alone.reason) == ((), "")
    _, due = proposed(0.9 * worth)
    assert due.score == 1.0 > due.threshold
    assert due.action == alone.action
    assert due.triggers
    assert due.reason == "precaution: worth 1.000 above 1.000"
    _, half = proposed(2.0 * worth)
    assert half.score == pytest.approx(0.999999 / 2.0)
    assert not half.triggers
    _, alarmed = proposed(0.9 * worth, threshold=0.0)
    assert alarmed.reason.startswith("criticality")
    assert proposed(0.9 * worth, threshold=0.5)[1].score == pytest.approx(0.5 / 0.9)


def test_no_precaution_in_front_of_who_closes_in(tmp_path):
    weighing = Weighing(strength=0.0, any=0.0, gain=1e-6, rear=3.0)
    path = save_tiny_model(tmp_path / "rear.safetensors", threshold=0.999999, weighing=weighing)
    careless = weighing.model_copy(update={"rear": 0.0})
    other = made(save_tiny_model(tmp_path / "careless.safetensors", threshold=0.999999, weighing=careless))
    far, near = scene_of([Box(1, -60.0, 0.0, speed=12.0)]), scene_of([Box(1, -15.0, 0.0, speed=15.0)])
    method = made(path)
    assert method.propose(far, keep_on(far, action=0.9)).reason.startswith("precaution")
    assert other.propose(near, keep_on(near, action=0.9)).reason.startswith("precaution")
    proposal = method.propose(near, keep_on(near, action=0.9))
    assert proposal.score < proposal.threshold
    assert (proposal.triggers, proposal.reason) == ((), "")
    alarmed = made(path, threshold=0.0)
    assert alarmed.propose(near, keep_on(near, action=0.9)).reason.startswith("criticality")


def test_the_policys_action_matters_to_the_monitor(model):
    scene = crowd(3, 4)
    scores = {made(model).propose(scene, keep_on(scene, action=action)).score for action in (-1.0, 0.0, 1.0)}
    assert len(scores) == 3


def test_a_threshold_replaces_the_models_own(model):
    scene = crowd(3, 4)
    score = made(model).propose(scene, keep_on(scene)).score
    assert made(model, threshold=0.0).propose(scene, keep_on(scene)).threshold == 0.0
    repairer = make_repairer("adreft", {"model": str(model), "threshold": 1.0})
    repairer.reset(straight_route())
    repair = repairer.step(scene, keep_on(scene))
    assert (repair.score, repair.intervened, repair.triggers) == (score, False, ())


def test_it_names_those_who_drew_most_attention(model):
    scene = crowd(5, 6)
    method = made(model, threshold=0.0)
    proposal = method.propose(scene, keep_on(scene, points=4))
    attention = method.model.attention[:6]  # a token for each participant, in their order
    best = sorted(range(6), key=lambda row: -attention[row])[:3]
    assert [trigger.object_id for trigger in proposal.triggers] == [10 + row for row in best]
    assert [trigger.weight for trigger in proposal.triggers] == pytest.approx([float(attention[row]) for row in best])
    assert proposal.reason == f"criticality {proposal.score:.3f} above 0.000"
    assert made(model, threshold=0.0).propose(crowd(0, 0), keep_on(scene)).triggers == ()


def test_the_latch_of_a_model_holds_an_intervention(tmp_path):
    path = save_tiny_model(tmp_path / "held.safetensors", hold=0.3)
    held, free = made(path, threshold=0.0), made(path, threshold=0.0)
    first = scene_of([Box(1, 30.0, 0.0)], 1.0)
    assert held.propose(first, keep_on(first)).score > 0.0
    held.threshold = free.threshold = 1.0
    later = scene_of([Box(1, 30.0, 0.0)], 1.2)
    proposal = held.propose(later, keep_on(later))
    assert proposal.score > proposal.threshold
    assert "held 0.20 s" in proposal.reason
    assert free.propose(later, keep_on(later)).reason == ""


def test_a_choice_holds_for_the_interval(tmp_path, monkeypatch):
    held = made(save_tiny_model(tmp_path / "held.safetensors", interval=3))
    calls = iter(range(100))
    monkeypatch.setattr(
        AdreftModel, "values", lambda _self, _state, _action: np.eye(10, dtype=np.float32)[next(calls) % 10]
    )
    scenes = [scene_of([Box(1, 30.0, 0.0)], 0.05 * tick) for tick in range(9)]
    found = [held.propose(scene, keep_on(scene)).action for scene in scenes]
    assert found == [ACTIONS[tick - tick % 3] for tick in range(9)]
    held.propose(scenes[0], keep_on(scenes[0]))
    held.reset(straight_route())  # in the middle of an interval
    assert held.propose(scenes[0], keep_on(scenes[0])).action == ACTIONS[0]  # the eleventh call


def test_an_action_must_be_worth_the_margin_more_than_the_policys_own(tmp_path, monkeypatch):
    method = made(save_tiny_model(tmp_path / "model.safetensors", margin=0.5))
    values = np.array([0.0, 0.1, 0.2, 0.3, 0.0, 0.0, 0.65, 0.0, 0.0, 0.0], dtype=np.float32)
    monkeypatch.setattr(AdreftModel, "values", lambda _self, _state, _action: values)
    scene = crowd(1, 2)

    def chosen(asked):
        method.reset(straight_route())
        return method.propose(scene, keep_on(scene, action=asked)).action

    assert chosen(0.55) == ACTIONS[6]  # better by 0.55 than 0.8 and 0.6, which do nothing here
    assert chosen(0.3) == ACTIONS[0]  # 0.4 does nothing either, and is worth 0.2
    assert chosen(0.9) == ACTIONS[6]  # nothing is idle; 0.8 stands in


def test_rand_r_draws_and_repeats_itself(tmp_path):
    path = save_tiny_model(tmp_path / "random.safetensors", choice="random")
    scene = crowd(1, 3)

    def actions(seed):
        method = AdreftRepair(AdreftParameters(model=str(path)), seed)
        method.reset(straight_route())
        return [method.propose(scene, keep_on(scene)).action for _ in range(200)]

    assert actions(1) == actions(1) != actions(2)
    assert set(actions(1)) == set(ACTIONS)


@pytest.mark.parametrize("name", TOKENIZERS)
def test_a_model_runs_with_every_tokenizer(tmp_path, name):
    path = save_tiny_model(tmp_path / "model.safetensors", tokenizer=name)
    repairer = make_repairer("adreft", {"model": str(path)})
    repairer.reset(straight_route())
    scene = crowd(2, 5)
    assert repairer.step(scene, keep_on(scene)).status is RepairStatus.RESET
    later = scene_of([], 0.05)
    assert repairer.step(later, keep_on(later)).status in {RepairStatus.PASS, RepairStatus.REPAIRED}


def test_values_that_are_not_finite_are_a_fault(model, monkeypatch):
    monkeypatch.setattr(AdreftModel, "values", lambda *_: np.full(10, np.nan, np.float32))
    repairer = make_repairer("adreft", {"model": str(model)})
    repairer.reset(straight_route())
    scene = crowd(2, 5)
    repair = repairer.step(scene, keep_on(scene))
    assert repair.status is RepairStatus.MODEL_FAULT
    assert "values are not finite" in repair.reason


# -- what is refused ---------------------------------------------------------------------------------------------------


def refusal(model):
    with pytest.raises(InputError) as caught:
        make_repairer("adreft", {"model": str(model)})
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_a_missing_model_is_refused(tmp_path):
    assert "no such model file" in refusal(tmp_path / "none.safetensors")
    assert "roadmend ships no adreft-nobody.safetensors; choose one of: " in refusal("nobody")
    assert "ships no" in refusal("../models/adreft-modular")


def test_a_cut_or_foreign_model_is_refused(tmp_path, model):
    content = model.read_bytes()
    for size in (0, 7, 100, len(content) - 1):
        (tmp_path / "cut.safetensors").write_bytes(content[:size])
        assert "cut or damaged" in refusal(tmp_path / "cut.safetensors")
    flipped = bytearray(content)
    flipped[-3] ^= 0x10
    (tmp_path / "flipped.safetensors").write_bytes(flipped)
    assert "changed or damaged" in refusal(tmp_path / "flipped.safetensors")


def changed(tmp_path, tensors=None, configuration=None, **header):
    configuration = configuration or configuration_of()
    path = tmp_path / "changed.safetensors"
    tensors = {**random_tensors(configuration_of()), **(tensors or {})}
    save_checkpoint(path, tensors, header_of(configuration, **header))
    return refusal(path)


def test_a_model_that_does_not_fit_is_refused(tmp_path):
    assert "kind 'neural'" in changed(tmp_path, kind="neural")
    assert "has no threshold" in changed(tmp_path, threshold=None)
    assert "version 99" in changed(tmp_path, configuration=configuration_of(tokenizer_version=99))
    assert "shape (3, 9) wanted" in changed(tmp_path, configuration=configuration_of(monitor=(3,)))
    assert "not finite" in changed(tmp_path, {"encoder.cls": np.full(8, np.nan, np.float32)})


def test_a_foreign_configuration_is_refused(tmp_path):
    path = tmp_path / "foreign.safetensors"
    plain = json.loads(configuration_of().model_dump_json())
    for configuration, words in (
        ({"model": plain | {"tokenizer": "words"}}, "no 'words'"),
        ({"model": plain | {"wings": 2}}, "configuration is not that of a model of ADReFT"),
        ({}, "configuration is not that of a model of ADReFT (it has no 'model')"),
    ):
        header = header_of(configuration_of()) | {"configuration": configuration}
        save_checkpoint(path, random_tensors(configuration_of()), header)
        assert words in refusal(path)
