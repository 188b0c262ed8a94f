"""Practice: returns by hand, values learned from made-up trials, an interruption that changes no bit."""

import numpy as np
import pytest

from roadmend.core.outcome import EventKind
from roadmend.repair.actions import ACTIONS
from roadmend.training.adreft.configuration import ModelSection, PracticeSection
from roadmend.training.adreft.practice import PracticeStage
from roadmend.training.adreft.stage import StageRun
from roadmend.training.adreft.trial_set import TrialSet
from roadmend.training.adreft.trials import PASS, CaseTrials
from roadmend.training.device import choose_torch_device

MODEL = ModelSection(hidden=16, layers=1, heads=2, feed_forward=16, monitor=(16,), adapter=(16,)).configuration()
COLLISION, GOAL, TIMEOUT = int(EventKind.COLLISION), int(EventKind.GOAL), int(EventKind.TIMEOUT)


@pytest.fixture(autouse=True)
def _one_thread():
    choose_torch_device("cpu", 1)


def trials_of(outcomes, choices, actions, attribute=None, name="case"):
    """Episodes of equal length whose decisions have one token each."""
    count = len(outcomes)
    length = len(choices) // count
    tokens = np.zeros((len(choices), 6), dtype=np.float16)
    tokens[:, 0] = 1.0
    tokens[:, 1] = 0.0 if attribute is None else attribute
    action, choice = np.asarray(actions, dtype=np.float32), np.asarray(choices, dtype=np.int8)
    time = np.tile(0.2 * np.arange(length), count)
    held = np.where(choice == PASS, action, np.array(ACTIONS, dtype=np.float32)[choice])
    dose = 0.2 * np.maximum(action - held, 0.0)
    return CaseTrials(
        name,
        np.array(outcomes, dtype=np.int8),
        np.full(count, 0.2 * length),
        np.full(count, length, dtype=np.int32),
        time,
        action,
        choice,
        dose.astype(np.float32),
        np.full(len(choices), np.inf, dtype=np.float32),
        np.ones(len(choices), dtype=np.int32),
        tokens,
    )


def test_returns_by_hand():
    section = PracticeSection(epochs=1, gamma=0.5, steps=2, dose=1.0, time=0.0, before_collision=0.45)
    trials = trials_of([COLLISION, TIMEOUT, GOAL], [0, 4, 0] * 3, [0.5, 0.5, 0.5] * 3)
    found = TrialSet.join([trials, trials], section)
    assert len(found) == 18
    # Doses are 0, 0.1, 0; the last decision bears the end of the episode.
    np.testing.assert_allclose(found.total[:9], [-2.55, -5.1, -10.0, -2.55, -5.1, -10.0, -0.05, -0.1, 0.0], atol=1e-6)
    np.testing.assert_allclose(found.reward[:3], [-0.05, -5.1, -10.0], atol=1e-6)
    np.testing.assert_allclose(found.discount[:3], [0.25, 0.0, 0.0])
    assert found.following[9:12].tolist() == [11, -1, -1]
    assert found.critical[:9].tolist() == [0.0, 1.0, 1.0] + [0.0] * 6
    # What was braked within the next 0.45 s and went well says nothing of the policy.
    assert found.judged[:9].tolist() == [0.0, 1.0, 1.0] + [0.0, 0.0, 1.0] * 2
    # 0.8 and 0.6 do as little as the policy's own 0.5; braking is alike to itself alone.
    assert found.alike[0].tolist() == [True, True] + [False] * 8
    assert np.flatnonzero(found.alike[1]).tolist() == [4]


def test_an_exponent_makes_gentle_interventions_cheaper_than_hard_ones_of_the_same_dose():
    section = PracticeSection(epochs=1, gamma=1.0, dose=1.0, dose_exponent=2.0, time=0.0)
    hard = trials_of([GOAL], [ACTIONS.index(-0.2), PASS, PASS, PASS], [0.6] * 4)
    gentle = trials_of([GOAL], [ACTIONS.index(0.4)] * 4, [0.6] * 4)
    np.testing.assert_allclose(hard.dose.sum(), gentle.dose.sum(), rtol=1e-5)
    found = TrialSet.join([hard, gentle], section)
    np.testing.assert_allclose(found.total[[0, 4]], [-0.16 * 0.8, -0.16 * 0.2], atol=1e-6)


def test_the_policys_own_action_is_like_all_that_would_not_have_changed_it():
    section = PracticeSection(epochs=1)
    found = TrialSet.join([trials_of([GOAL], [PASS, PASS, 0], [0.3, 0.9, 0.9])], section)
    assert np.flatnonzero(found.alike[0]).tolist() == [0, 1, 2]
    assert not found.alike[1].any()  # no action of a repair lets 0.9 pass
    assert np.flatnonzero(found.alike[2]).tolist() == [0]


def lesson(seed, cases=60):
    """Where the attribute is high, an episode ends in a collision unless it is braked with -0.4 or harder."""
    numbers = np.random.default_rng(seed)
    made = []
    for number in range(cases):
        danger = bool(numbers.integers(2))
        choice = int(numbers.integers(len(ACTIONS)))
        outcome = COLLISION if danger and ACTIONS[choice] > -0.3 else GOAL
        made.append(trials_of([outcome], [choice] * 3, [0.4] * 3, float(danger), f"{seed}-{number}"))
    return made


def stage_of(state, **changes):
    section = PracticeSection(
        **{"epochs": 30, "learning_rate": 1e-2, "batch": 32, "monte_carlo_epochs": 25, "dose": 2.0, **changes}
    )
    return PracticeStage(MODEL, section, TrialSet.join(lesson(1), section), StageRun(2, "cpu", state))


def values_of(stage, danger):
    tokens = np.zeros((1, 1, 6), dtype=np.float32)
    tokens[0, 0, :2] = 1.0, danger
    to = stage._to
    return stage.network(to(tokens), to(np.ones((1, 1), dtype=bool)), to(np.array([0.4], dtype=np.float32)))[1][0]


def test_it_learns_when_braking_is_worth_its_price(tmp_path):
    stage = stage_of(tmp_path / "state")
    reports = []
    stage.run(reports.append)
    assert reports[-1].value_loss < 0.3 * reports[0].value_loss
    danger, calm = values_of(stage, 1.0), values_of(stage, 0.0)
    assert -0.9 < ACTIONS[int(danger.argmax())] < -0.3
    assert ACTIONS[int(calm.argmax())] >= 0.2


def test_an_interruption_changes_no_bit(tmp_path):
    class StoppedError(Exception):
        pass

    def stop(figures):
        if figures.epoch == 2:
            raise StoppedError

    whole = stage_of(tmp_path / "whole", epochs=4, monte_carlo_epochs=1).run()
    with pytest.raises(StoppedError):
        stage_of(tmp_path / "cut", epochs=4, monte_carlo_epochs=1).run(stop)
    resumed = stage_of(tmp_path / "cut", epochs=4, monte_carlo_epochs=1).run()
    assert whole.keys() == resumed.keys()
    assert all(np.array_equal(whole[name], resumed[name]) for name in whole)
