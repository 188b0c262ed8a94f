"""Counterfactuals: labels by hand, chances learned from made-up trials, an interruption that changes no bit."""

import numpy as np
import pytest
import torch

from roadmend.core.errors import InputError
from roadmend.repair.actions import ACTIONS
from roadmend.repair.adreft.weighing import AVERTED, CAUSED, DANGER, Weighing
from roadmend.training.adreft.configuration import ModelSection, PracticeSection
from roadmend.training.adreft.counterfactual import Counterfactuals
from roadmend.training.adreft.counterfactual_stage import CounterfactualStage
from roadmend.training.adreft.stage import StageRun
from roadmend.training.adreft.trial_set import TrialSet
from roadmend.training.adreft.trials import PASS
from roadmend.training.device import choose_torch_device

from .test_adreft_practice import COLLISION, GOAL, TIMEOUT, trials_of

MODEL = ModelSection(
    hidden=16, layers=1, heads=2, feed_forward=16, monitor=(16,), adapter=(16,), weighing=Weighing()
).configuration()
NONE = float("nan")


@pytest.fixture(autouse=True)
def _one_thread():
    choose_torch_device("cpu", 1)


def test_labels_by_hand():
    section = PracticeSection(epochs=1, gamma=0.5, lasting=0.3)
    # Alone it collides; a brake from the second decision on brings it to its goal, another one does not.
    choices = [PASS] * 4 + [PASS, 6, 6, 6] + [PASS, 7, PASS, PASS]
    trials = trials_of([COLLISION, GOAL, COLLISION], choices, [0.5] * 12)
    found = Counterfactuals.join([trials], section)
    np.testing.assert_array_equal(
        found.danger, np.array([0.125, 0.25, 0.5, 1.0] + [NONE] * 4 + [NONE, NONE, 0.5, 1.0], dtype=np.float32)
    )
    np.testing.assert_array_equal(  # the fourth decision of the second episode comes too late to tell of its begin
        found.averted, np.array([NONE] * 4 + [NONE, 1.0, 1.0, NONE] + [NONE, 0.0, NONE, NONE], dtype=np.float32)
    )
    assert np.isnan(found.caused).all()
    assert found.tried[[5, 6, 9]].tolist() == [6, 6, 7]
    assert found.alone.tolist() == [0, 1, 2, 3, 10, 11]
    assert found.interfered.tolist() == [5, 6, 9]


def test_where_the_policy_alone_arrives_an_intervention_can_only_do_harm():
    section = PracticeSection(epochs=1)
    trials = trials_of([GOAL, COLLISION, TIMEOUT], [PASS, PASS, 9, PASS, 9, PASS], [0.5] * 6)
    found = Counterfactuals.join([trials], section)
    assert found.caused[[2, 4]].tolist() == [1.0, 0.0]
    assert np.isnan(found.averted).all()
    assert found.danger[[0, 1]].tolist() == [0.0, 0.0]


def test_trials_tell_nothing_before_the_policys_own_drive_is_known():
    trials = trials_of([GOAL], [9, PASS], [0.5, 0.5])
    assert not len(Counterfactuals.join([trials], PracticeSection(epochs=1)).interfered)


def test_what_is_driven_blinded_is_held_against_its_own_drive():
    choices = [PASS, PASS, 9, PASS, PASS, PASS, 9, PASS]  # goal, goal; blinded: collision, goal
    trials = trials_of([GOAL, GOAL, COLLISION, GOAL], choices, [0.5] * 8)
    found = Counterfactuals.join([trials], PracticeSection(epochs=1))
    assert found.caused[2] == 0.0
    assert found.averted[6] == 1.0


def test_what_does_not_brake_harder_than_the_policy_tells_nothing():
    trials = trials_of([COLLISION, GOAL], [PASS, PASS, 0, 0], [0.5] * 4)
    assert not len(Counterfactuals.join([trials], PracticeSection(epochs=1)).interfered)


def worlds():
    """Where the attribute is 1 the policy collides and full braking averts it, half the time; where it is 0, nothing."""
    cases = []
    for number in range(60):
        hot = number % 2
        good = GOAL if not hot or number % 4 == 1 else COLLISION
        outcomes = [COLLISION if hot else GOAL, good]
        cases.append(trials_of(outcomes, [PASS, PASS, 9, PASS], [0.5] * 4, attribute=hot, name=str(number)))
    return cases


def stage_of(tmp_path, epochs=30, state="state.safetensors", model=MODEL):
    section = PracticeSection(
        epochs=epochs, method="counterfactual", gamma=1.0, batch=32, learning_rate=1e-2, dropout=0.1
    )
    trials = worlds()
    labels = Counterfactuals.join(trials, section)
    return CounterfactualStage(
        model, section, TrialSet.join(trials, section), labels, StageRun(3, "cpu", tmp_path / state)
    )


def test_chances_are_learned(tmp_path):
    stage = stage_of(tmp_path)
    stage.run()
    tokens = np.zeros((2, 1, 6), dtype=np.float32)
    tokens[:, 0, 0], tokens[1, 0, 1] = 1.0, 1.0
    network = stage.network.eval()
    with torch.no_grad():
        _, outputs = network(torch.from_numpy(tokens), torch.ones(2, 1, dtype=torch.bool), torch.full((2,), 0.5))
    chances = torch.sigmoid(outputs).numpy()
    assert chances[0, DANGER] < 0.1
    assert chances[1, AVERTED][9] == pytest.approx(0.5, abs=0.15)
    assert chances[0, CAUSED][9] < 0.1
    assert len(ACTIONS) == 10


def test_an_interruption_changes_no_bit(tmp_path):
    whole = stage_of(tmp_path, epochs=4, state="whole.safetensors").run()

    def stop(figures):
        if figures.epoch == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        stage_of(tmp_path, epochs=4, state="parts.safetensors").run(stop)
    parts = stage_of(tmp_path, epochs=4, state="parts.safetensors").run()
    assert all(np.array_equal(whole[name], parts[name]) for name in whole)


def test_other_prices_go_with_the_same_networks(tmp_path):
    stage_of(tmp_path, epochs=2).run()
    priced = MODEL.model_copy(update={"weighing": Weighing(strength=1.0)})
    assert stage_of(tmp_path, epochs=2, model=priced).epoch == 2
    with pytest.raises(InputError, match="begun with another 'model'"):
        stage_of(tmp_path, epochs=2, model=priced.model_copy(update={"interval": 7}))


def test_trials_that_tell_nothing_are_refused(tmp_path):
    section = PracticeSection(epochs=1, method="counterfactual")
    trials = [trials_of([GOAL], [PASS, PASS], [0.5, 0.5])]
    labels = Counterfactuals.join(trials, section)
    with pytest.raises(InputError, match="tells of an intervention"):
        CounterfactualStage(MODEL, section, TrialSet.join(trials, section), labels, StageRun(0, "cpu", tmp_path / "s"))
