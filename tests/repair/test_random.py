from collections import Counter

import pytest

from roadmend.core.repair import Proposal
from roadmend.repair.actions import ACTIONS, braking_action
from roadmend.repair.parameters import RandomParameters
from roadmend.repair.random import RandomRepair

from .playground import keep_on, scene_of, straight_route

SCENE = scene_of([])
DECISION = keep_on(SCENE)


def draw(method, number) -> list[Proposal]:
    return [method.propose(SCENE, DECISION) for _ in range(number)]


def test_an_episode_is_reproducible_whatever_ran_before():
    method = RandomRepair(seed=3)
    method.reset(straight_route())
    first = draw(method, 50)
    method.reset(straight_route(name="other"))
    assert draw(method, 50) != first
    method.reset(straight_route())
    assert draw(method, 50) == first
    assert draw(method, 50) != first


def test_seeds_differ():
    assert draw(RandomRepair(seed=1), 20) != draw(RandomRepair(seed=2), 20)


@pytest.mark.parametrize("probability", [0.0, 0.1, 0.5, 1.0])
def test_it_steps_in_as_often_as_told(probability):
    proposals = draw(RandomRepair(RandomParameters(probability=probability)), 4000)
    share = sum(proposal.score > proposal.threshold for proposal in proposals) / 4000
    assert share == pytest.approx(probability, abs=0.03 if 0.0 < probability < 1.0 else 0.0)


def test_actions_are_uniform_over_the_action_space():
    assert ACTIONS == (0.8, 0.6, 0.4, 0.2, 0.0, -0.2, -0.4, -0.6, -0.8, -1.0)
    counts = Counter(proposal.action for proposal in draw(RandomRepair(), 5000))
    assert set(counts) == set(ACTIONS)
    assert max(counts.values()) < 1.25 * min(counts.values())


@pytest.mark.parametrize(
    ("needed", "action"),
    [
        (-3.0, 0.0),
        (0.0, 0.0),
        (0.01, -0.2),
        (1.6, -0.2),
        (1.61, -0.4),
        (4.8, -0.6),
        (7.9, -1.0),
        (8.0, -1.0),
        (99.0, -1.0),
        (float("inf"), -1.0),
    ],
)
def test_the_mildest_bin_that_suffices(needed, action):
    assert braking_action(needed, 8.0) == action
