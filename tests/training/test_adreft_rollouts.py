"""Rollouts: what acting gains over waiting, told by the same futures; the adapter learns it, all else stays."""

import numpy as np
import pytest
import torch

from roadmend.core.command import Command, Decision, Trajectory
from roadmend.core.errors import InputError
from roadmend.core.outcome import Event, EventKind
from roadmend.core.scene import EgoState, ObjectList, Scene
from roadmend.policies.registry import POLICIES
from roadmend.repair.actions import ACTIONS
from roadmend.repair.adreft.model import AdreftModel
from roadmend.repair.adreft.weighing import Weighing
from roadmend.training.adreft.case_rollouts import CaseRollouts
from roadmend.training.adreft.configuration import ModelSection
from roadmend.training.adreft.deferred import DeferredRepairer
from roadmend.training.adreft.gathering import Recipe
from roadmend.training.adreft.holding import HoldingRepairer
from roadmend.training.adreft.network import AdreftNetwork, save_model
from roadmend.training.adreft.rollouts import RolloutPlan, _lost, gather_rollouts, rollouts_of_case
from roadmend.training.adreft.rollouts_configuration import RolloutsSection
from roadmend.training.adreft.rollouts_stage import RolloutsStage
from roadmend.training.adreft.trial_plan import Hold
from roadmend.training.device import choose_torch_device
from roadmend.training.torch_state import tensors_of
from roadmend.world.futures import Future

from .blind import ENTRY, blind_corpus
from .cases import Drawn

STRONGEST = len(ACTIONS) - 1
RECIPE, BLIND = Recipe("modular", "rich", 1), Recipe("blind", "rich", 1)


@pytest.fixture(autouse=True)
def _one_thread():
    choose_torch_device("cpu", 1)


def plan_of(**changes):
    values = {"moments": 2, "futures": 2, "actions": 1, "score": 0.1, "chance": 1.0, "seed": 7, "guide": "a"}
    return RolloutPlan(**{**values, **changes})


def guide_of(path, threshold):
    """A model whose monitor says 0.5 of everything, and asks its adapter only below that."""
    model = (
        ModelSection(
            tokenizer="rich", hidden=8, layers=1, heads=1, feed_forward=8, monitor=[4], adapter=[4], weighing=Weighing()
        )
        .configuration()
        .model_copy(update={"interval": 12, "fresh": True})
    )
    torch.manual_seed(0)
    tensors = tensors_of(AdreftNetwork(model))
    for name in tensors:
        if name.startswith("monitor."):
            tensors[name] = np.zeros_like(tensors[name])
    save_model(path, model, tensors, threshold)
    return path


def test_the_choice_of_a_moment_is_played_and_then_the_one_within_goes_on():
    def finals(choice):
        repairer = DeferredRepairer(HoldingRepairer((Hold(0.0, 2.0, 6),)), 1.0, choice)
        found = []
        for time in 0.05 * np.arange(41):
            ego = EgoState.from_yaw(0.0, 0.0, 0.0, 5.0, 0.0, 4.5, 1.8)
            scene = Scene(float(time), ego, ObjectList.empty(), np.zeros(0, dtype=np.uint8))
            found.append(repairer.step(scene, Decision(Command.from_action(0.9), Trajectory.empty())).final_action)
        return np.array(found)

    acted, waited = finals(STRONGEST), finals(None)
    assert (acted[:20] == -1.0).all()
    assert (waited[:20] == 0.9).all()  # above the mildest action, too
    np.testing.assert_array_equal(acted[20:], waited[20:])
    assert acted[20:40] == pytest.approx(-0.4)
    assert acted[40] == 0.9


def test_in_an_empty_world_acting_gains_nothing_and_loses_time(tmp_path):
    guide = guide_of(tmp_path / "guide.safetensors", 0.9)
    [found] = gather_rollouts([Drawn("S5", 3)], RECIPE, plan_of(), guide, tmp_path / "kept", map)
    assert len(found) == 2
    assert found.score == pytest.approx([0.5, 0.5])
    assert found.outcome == "GOAL"
    assert not found.collided.any()
    assert not found.collided_then.any()
    assert (found.lost > 0.0).all()
    assert found.lost.max() < 5.0
    assert (np.array(ACTIONS)[found.choice] < found.action[found.moment]).all()
    [path] = (tmp_path / "kept").iterdir()
    before = path.stat().st_mtime_ns
    [again] = gather_rollouts([Drawn("S5", 3)], RECIPE, plan_of(), guide, tmp_path / "kept", map)
    assert path.stat().st_mtime_ns == before
    np.testing.assert_array_equal(again.lost, found.lost)
    gather_rollouts([Drawn("S5", 3)], RECIPE, plan_of(guide="b"), guide, tmp_path / "kept", map)
    assert len(list((tmp_path / "kept").iterdir())) == 2


def test_where_the_monitor_is_quiet_nobody_looks(tmp_path):
    guide = guide_of(tmp_path / "guide.safetensors", 0.9)
    found = rollouts_of_case(Drawn("S5", 3), RECIPE, plan_of(score=0.6), guide)
    assert len(found) == len(found.moment) == len(found.tokens) == 0
    with pytest.raises(InputError, match="show no moment"):
        stage_of([found])


def test_acting_late_averts_what_waiting_does_not(tmp_path, monkeypatch):
    monkeypatch.setitem(POLICIES, "blind", ENTRY)
    [case] = (case for case in blind_corpus(1, 0).cases if case.is_violation)
    guide = guide_of(tmp_path / "guide.safetensors", 0.9)
    found = rollouts_of_case(case, BLIND, plan_of(moments=40, chance=0.15, actions=3), guide)
    assert found.outcome == "COLLISION"
    assert found.collided.max() == 1.0  # the guide never steps in
    strong = found.choice >= STRONGEST - 2
    assert (found.collided_then[strong] < found.collided[found.moment[strong]]).any()


def future_of(kind, duration, driven):
    return Future(None if kind is None else Event(duration, kind, ""), duration, 0.0, 0.0, 0.0, driven)


@pytest.mark.parametrize(
    ("waited", "acted", "lost"),
    [
        ((EventKind.GOAL, 9.0, 120.0), (EventKind.GOAL, 11.0, 120.0), 2.0),
        ((EventKind.GOAL, 9.0, 120.0), (EventKind.OFF_ROUTE, 3.0, 40.0), 6.0),  # 80 m short, at 13.3 m/s
        ((EventKind.GOAL, 9.0, 120.0), (EventKind.OFF_ROUTE, 9.0, 150.0), 0.0),  # farther, but not there
        ((EventKind.TIMEOUT, 5.0, 60.0), (EventKind.TIMEOUT, 5.0, 12.0), 4.0),
        ((EventKind.OFF_ROUTE, 3.0, 30.0), (None, 12.0, 90.0), -6.0),
        ((None, 12.0, 120.0), (None, 12.0, 100.0), 2.0),
    ],
)
def test_time_is_lost_to_the_goal_and_not_to_just_any_end(waited, acted, lost):
    assert _lost(future_of(*waited), future_of(*acted)) == pytest.approx(lost)


def rollouts_of(number, attribute, collided, collided_then, lost):
    """One moment with one token, at which full braking was tried."""
    tokens = np.zeros((1, 6), dtype=np.float16)
    tokens[0, :2] = 1.0, attribute
    one = np.float32
    return CaseRollouts(
        f"case-{number}",
        "GOAL",
        np.zeros(1),
        np.full(1, 0.5, dtype=one),
        np.full(1, 0.5, dtype=one),
        np.full(1, collided, dtype=one),
        np.ones(1, dtype=np.int32),
        tokens,
        np.zeros(1, dtype=np.int32),
        np.full(1, STRONGEST, dtype=np.int8),
        np.full(1, collided_then, dtype=one),
        np.full(1, lost, dtype=one),
    )


MODEL = ModelSection(
    hidden=16,
    layers=1,
    heads=2,
    feed_forward=16,
    monitor=(16,),
    adapter=(16,),
    weighing=Weighing(strength=0.0, any=0.0),
).configuration()


def stage_of(rollouts, **changes):
    torch.manual_seed(1)
    section = RolloutsSection(**{"epochs": 60, "learning_rate": 1e-2, "batch": 16, **changes})
    return RolloutsStage(MODEL, section, rollouts, tensors_of(AdreftNetwork(MODEL)), 3, "cpu")


def test_the_adapter_learns_to_act_where_it_pays_and_nothing_else_moves(tmp_path):
    pays = [rollouts_of(number, 1.0, 1.0, 0.0, 2.0) for number in range(40)]
    idle = [rollouts_of(number + 40, 0.0, 0.0, 0.0, 4.0) for number in range(40)]
    tensors, figures = stage_of([*pays, *idle], time=0.5).run()
    before = tensors_of(AdreftNetwork(MODEL))
    assert (figures.moments, figures.tried) == (80, 80)
    assert figures.epoch > 0
    assert figures.loss < figures.loss_before
    assert figures.gained > 0.0  # half of the moments gain 10 - 1, where it acts
    assert all(np.isfinite(value).all() for value in tensors.values())
    assert tensors.keys() == before.keys()
    path = tmp_path / "tuned.safetensors"
    save_model(path, MODEL, tensors, 0.5)
    model = AdreftModel.load(path)
    for attribute, acts in ((1.0, True), (0.0, False)):
        tokens = np.zeros((1, 6), dtype=np.float32)
        tokens[0, :2] = 1.0, attribute
        values = model.values(model.encode(tokens), 0.5)
        assert (values[STRONGEST] > values[0]) == acts
        assert values[STRONGEST] - values[0] == pytest.approx(9.0 if acts else -2.0, abs=1.5)
    again, _ = stage_of([*pays, *idle], time=0.5).run()
    assert all(np.array_equal(tensors[name], again[name]) for name in tensors)
    torch.manual_seed(1)
    start = tensors_of(AdreftNetwork(MODEL))
    moved = {name.split(".")[0] for name in tensors if not np.array_equal(tensors[name], start[name])}
    assert moved == {"adapter"}


@pytest.mark.parametrize("share", [1e-4, 0.9999])
def test_without_a_case_to_judge_by_or_one_to_learn_of_nothing_is_tuned(share):
    with pytest.raises(InputError, match="held_out"):
        stage_of([rollouts_of(each, 1.0, 1.0, 0.0, 0.0) for each in range(5)], held_out=share)


def test_the_price_of_time_decides():
    slow = [rollouts_of(number, 1.0, 0.5, 0.0, 8.0) for number in range(30)]
    cheap, dear = (stage_of(slow, time=price).run()[1] for price in (0.1, 2.0))
    assert cheap.gained > 3.0  # 5 averted, 0.8 paid
    assert dear.gained == 0.0  # 16 would be paid


def test_an_adapter_that_no_epoch_betters_is_kept():
    rollouts = [rollouts_of(number, 1.0, 1.0, 0.0, 0.0) for number in range(20)]
    tensors, _ = stage_of(rollouts).run()
    stage = RolloutsStage(MODEL, RolloutsSection(epochs=2, learning_rate=1e-9), rollouts, tensors, 3, "cpu")
    kept, figures = stage.run()
    assert figures.loss <= figures.loss_before
    assert all(np.allclose(kept[name], tensors[name]) for name in kept)
