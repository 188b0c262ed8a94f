"""A method's braking at other times: the same blocks, and none before the begin or after the impact."""

import random

import pytest

from harness.shuffle import Block, BlockPlayer, blocks_of, shuffled
from roadmend.policies.registry import make_policy
from roadmend.repair.registry import make_repairer
from roadmend.world.families import sample_scenario
from roadmend.world.runner import run_episode

BLOCKS = [Block(10, (-0.2, -0.4)), Block(20, (-1.0,) * 12), Block(40, (0.0,))]


def test_blocks_keep_their_actions_and_stay_before_the_impact_and_apart():
    for number in range(50):
        placed = shuffled(BLOCKS, 60, f"case:{number}")
        assert sorted(block.actions for block in placed) == sorted(block.actions for block in BLOCKS)
        assert all(block.begin >= 0 and block.end <= 60 for block in placed)
        taken = [tick for block in placed for tick in range(block.begin, block.end)]
        assert len(set(taken)) == len(taken) == 15
    assert shuffled(BLOCKS, 60, "one") == shuffled(BLOCKS, 60, "one") != shuffled(BLOCKS, 60, "other")


def test_begins_are_spread_over_all_the_time_before():
    begins = [shuffled([Block(50, (-1.0,))], 100, str(random.random()))[0].begin for _ in range(400)]
    assert min(begins) < 10
    assert max(begins) > 90
    assert sum(begins) / 400 == pytest.approx(49.5, abs=6.0)


def test_what_is_longer_than_the_time_before_is_cut():
    (block,) = shuffled([Block(0, (-1.0,) * 30)], 10, "x")
    assert (block.begin, len(block.actions)) == (0, 10)


def test_a_method_is_played_back_to_the_bit_and_nothing_is_done_without_blocks():
    scenario = sample_scenario("S4", 3).model_copy(update={"time_limit": 6.0})
    result, blocks, waits = blocks_of(scenario, make_policy("modular"), make_repairer("random", seed=1))
    assert sum(len(block.actions) for block in blocks) == result.interventions > 0
    assert len(blocks) == len(result.spells)
    assert not waits.lengths
    again = run_episode(scenario, make_policy("modular"), BlockPlayer(blocks))
    assert (again.digest, again.interventions, again.dose) == (result.digest, result.interventions, result.dose)
    alone = run_episode(scenario, make_policy("modular"), make_repairer("none"))
    assert run_episode(scenario, make_policy("modular"), BlockPlayer([])).digest == alone.digest != result.digest
