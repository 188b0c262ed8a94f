"""Exploring episodes: who decides when, what is credited to which decision, and how decisions become transitions."""

import numpy as np
import pytest

from roadmend.core.command import Command, Decision, Trajectory
from roadmend.core.outcome import EventKind
from roadmend.core.repair import Repair, RepairStatus
from roadmend.core.route import Route, Stage
from roadmend.core.scene import EgoState, ObjectList, Scene
from roadmend.repair.actions import ACTIONS
from roadmend.training.adreft.configuration import ReinforcementSection
from roadmend.training.adreft.exploring import ExploringRepair, ReplayMemory, link

X = np.linspace(0.0, 500.0, 11)
ROUTE = Route("test", 4.7, 1.85, 480.0, 60.0, (Stage(X, 0.0 * X, np.full(11, 15.0)),), (), ())
EGO = EgoState.from_yaw(50.0, 0.0, 0.0, 10.0, 0.0, 4.7, 1.85)


class Scripted:
    """A model whose scores are given; its state is the number of the tick."""

    threshold = 0.5

    def __init__(self, scores, best=9):
        self._scores, self._best, self.tick = list(scores), best, -1

    def tokenizer(self):
        return self

    def reset(self, route):
        pass

    def tokens(self, scene, decision):
        return self

    @property
    def values(self):
        return lambda _state, _action: np.eye(len(ACTIONS), dtype=np.float32)[self._best]

    def encode(self, _tokens):
        self.tick += 1
        return np.array([self.tick], dtype=np.float32)

    def score(self, _state, _action):
        return self._scores[self.tick]


def run(scores, outcome=EventKind.GOAL, epsilon=0.0, policy=0.5, **section):
    """Drives through the scores; the merger's part is done here."""
    method = ExploringRepair(Scripted(scores), ReinforcementSection(**section), epsilon, np.random.default_rng(0))
    method.reset(ROUTE)
    actions = []
    for number, score in enumerate(scores):
        scene = Scene(0.05 * number, EGO, ObjectList.empty(), np.empty(0, np.uint8))
        decision = Decision(Command.from_action(policy), Trajectory.empty())
        proposal = method.propose(scene, decision)
        assert (proposal.score, proposal.threshold) == (score, 0.5)
        final = min(policy, proposal.action) if score > 0.5 else policy
        actions.append(final)
        method.watch(
            None,
            decision,
            Repair(Command.from_action(final), RepairStatus.PASS, score, 0.5, policy, proposal.action, final != policy),
        )
    method.end(outcome)
    return method.deeds, actions


def test_the_papers_rewards():
    """r = (1 - y_safe) (1 - 0.5 |a_ads - a_hat|); a violation ends with -10."""
    deeds, actions = run([0.2, 0.9, 0.6, 0.1], EventKind.COLLISION)
    assert actions == [0.5, -1.0, -1.0, 0.5]
    assert [deed.reward for deed in deeds] == pytest.approx([0.8, 0.1 * 0.25, 0.4 * 0.25, -10.0])
    assert [deed.discount for deed in deeds] == pytest.approx([0.99, 0.99, 0.99, 0.0])
    assert [deed.action for deed in deeds] == [9] * 4
    assert run([0.2, 0.1])[0][-1].reward == pytest.approx(0.9)


def test_without_the_step_reward_only_the_end_counts():
    assert [deed.reward for deed in run([0.2, 0.9], EventKind.COLLISION, step_reward=False)[0]] == [0.0, -10.0]
    assert [deed.reward for deed in run([0.2, 0.9], EventKind.TIMEOUT, step_reward=False, timeout=-5.0)[0]] == [
        0.0,
        -5.0,
    ]
    assert [deed.reward for deed in run([0.2, 0.9], EventKind.GOAL, step_reward=False, goal=7.0)[0]] == [0.0, 7.0]


def test_dose_has_its_price():
    rewards = [deed.reward for deed in run([0.2, 0.9], step_reward=False, dose=2.0)[0]]
    assert rewards == pytest.approx([0.0, -2.0 * 1.5 * 0.05])
    rewards = [deed.reward for deed in run([0.2, 0.9], step_reward=False, dose=2.0, dose_exponent=3.0)[0]]
    assert rewards == pytest.approx([0.0, -2.0 * 1.5**3 * 0.05])


def test_time_has_its_price_for_each_decision():
    rewards = [deed.reward for deed in run([0.2] * 6, step_reward=False, time=0.06, interval=3, gamma=1.0)[0]]
    assert rewards == pytest.approx([-0.06, -0.06])


def test_a_decision_holds_for_its_interval():
    deeds, _ = run([0.2] * 7, interval=3, gamma=0.5)
    assert [deed.state[0] for deed in deeds] == [0, 3, 6]
    assert [deed.reward for deed in deeds] == pytest.approx([0.8 * 1.75, 0.8 * 1.75, 0.8])
    assert [deed.discount for deed in deeds] == [0.125, 0.125, 0.0]


def test_the_adapter_may_decide_only_where_the_monitor_steps_in():
    deeds, _ = run(
        [0.2, 0.9, 0.9, 0.9, 0.1, 0.1, 0.8], decisions="critical", interval=2, gamma=1.0, step_reward=False, dose=1.0
    )
    assert [deed.state[0] for deed in deeds] == [1, 3, 6]
    assert [deed.reward for deed in deeds] == pytest.approx([-0.15, -0.075, -0.075])
    assert run([0.2, 0.3], EventKind.COLLISION, decisions="critical")[0] == []


def test_what_was_done_can_be_learned_from_instead_of_what_was_proposed():
    deeds, actions = run([0.2, 0.9], action="executed")
    assert actions == [0.5, -1.0]
    assert [ACTIONS[deed.action] for deed in deeds] == [pytest.approx(0.4, abs=0.21), -1.0]
    assert ACTIONS[run([0.2], action="executed", policy=1.0)[0][0].action] == 0.8


def test_exploration_is_uniform_and_repeats_itself():
    first, again = (run([0.9] * 500, epsilon=1.0)[0] for _ in range(2))
    chosen = [deed.action for deed in first]
    assert chosen == [deed.action for deed in again]
    assert min(np.bincount(chosen, minlength=10)) > 25


def test_transitions_reach_over_some_decisions():
    deeds, _ = run([0.2, 0.4, 0.6, 0.8], EventKind.COLLISION, gamma=0.5, policy=-1.0)
    one = link(deeds, 1, 1)
    assert one.reward.tolist() == pytest.approx([0.8, 0.6, 0.4, -10.0])
    assert one.discount.tolist() == [0.5, 0.5, 0.5, 0.0]
    assert one.after[:, 0].tolist() == [1.0, 2.0, 3.0, 0.0]
    three = link(deeds, 3, 1)
    assert three.reward.tolist() == pytest.approx([0.8 + 0.3 + 0.1, 0.6 + 0.2 - 2.5, 0.4 - 5.0, -10.0])
    assert three.discount.tolist() == [0.125, 0.0, 0.0, 0.0]
    assert three.after[:, 0].tolist() == [3.0, 0.0, 0.0, 0.0]
    assert len(link([], 3, 1)) == 0
    assert link([], 3, 5).after.shape == (0, 5)


def test_the_memory_forgets_the_oldest():
    memory = ReplayMemory(5, 1)
    for begin in range(0, 9, 3):
        deeds, _ = run([0.2] * 3)
        part = link(deeds, 1, 1)
        part.state[:] = np.arange(begin, begin + 3)[:, None]
        memory.add(part)
    assert (len(memory), memory.added) == (5, 9)
    drawn = memory.sample(200, np.random.default_rng(0))
    assert set(drawn.state[:, 0].tolist()) == {4.0, 5.0, 6.0, 7.0, 8.0}
    other = ReplayMemory(5, 1)
    other.load(memory.tensors("m."), "m.", 9)
    assert (other.sample(50, np.random.default_rng(1)).state == memory.sample(50, np.random.default_rng(1)).state).all()
