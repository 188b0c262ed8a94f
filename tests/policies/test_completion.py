"""The modular policy in the real simulation: a small sample of what it completes."""

from collections import Counter

import pytest

from roadmend.core.command import Decision
from roadmend.core.outcome import EventKind
from roadmend.core.repair import Repair, RepairStatus
from roadmend.core.scene import Scene
from roadmend.policies.registry import make_policy
from roadmend.world.families import FAMILIES, sample_scenario
from roadmend.world.runner import run_episode

SEEDS = range(1000, 1005)


class Unrepaired:
    name = "none"

    def reset(self, route) -> None:
        pass

    def step(self, scene: Scene, decision: Decision) -> Repair:
        action = decision.command.action
        return Repair(decision.command, RepairStatus.PASS, 0.0, 0.0, action, action, intervened=False)


def test_completes_most_of_a_random_sample():
    policy = make_policy("modular")
    outcomes = Counter(
        run_episode(sample_scenario(family, seed), policy, Unrepaired()).outcome
        for family in FAMILIES
        for seed in SEEDS
    )
    assert outcomes[EventKind.GOAL] >= 0.75 * len(FAMILIES) * len(SEEDS)
    assert outcomes[EventKind.OFF_ROUTE] + outcomes[EventKind.TIMEOUT] <= 0.1 * len(FAMILIES) * len(SEEDS)


@pytest.mark.parametrize("family", ["S1", "S5"])
def test_episodes_repeat_bit_for_bit_whatever_ran_before(family):
    fresh = run_episode(sample_scenario(family, 7), make_policy("modular"), Unrepaired())
    policy = make_policy("modular")
    run_episode(sample_scenario(family, 8), policy, Unrepaired())
    assert run_episode(sample_scenario(family, 7), policy, Unrepaired()).digest == fresh.digest
