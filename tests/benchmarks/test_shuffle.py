"""A method's braking at other times: the same blocks, and none before the begin or after the impact."""

import random

import pytest

from harness.shuffle import Block, BlockPlayer, blocks_of, shuffled
from roadmend.core.command import Command, Decision, Trajectory
from roadmend.core.outcome import EventKind
from roadmend.core.tick import INTERVAL
from roadmend.policies.registry import make_policy
from roadmend.repair.registry import make_repairer
from roadmend.world.corpus import corpus_of
from roadmend.world.families import sample_scenario
from roadmend.world.runner import run_episode

BLOCKS = [Block(10, (-0.2, -0.4), 1.0), Block(20, (-1.0,) * 12, 15.0), Block(40, (0.0,), 0.5)]


def test_blocks_keep_their_actions_and_stay_before_the_impact_and_apart():
    for number in range(50):
        placed = shuffled(BLOCKS, 60, f"case:{number}")
        assert {(block.actions, block.change) for block in placed} == {(each.actions, each.change) for each in BLOCKS}
        assert all(block.begin >= 0 and block.end <= 60 for block in placed)
        taken = [tick for block in placed for tick in range(block.begin, block.end)]
        assert len(set(taken)) == len(taken) == 15
    assert shuffled(BLOCKS, 60, "one") == shuffled(BLOCKS, 60, "one") != shuffled(BLOCKS, 60, "other")


def test_begins_are_spread_over_all_the_time_before():
    begins = [shuffled([Block(50, (-1.0,), 1.0)], 100, str(random.random()))[0].begin for _ in range(400)]
    assert min(begins) < 10
    assert max(begins) > 90
    assert sum(begins) / 400 == pytest.approx(49.5, abs=6.0)


def test_what_is_longer_than_the_time_before_is_cut():
    (block,) = shuffled([Block(0, (-1.0,) * 30, 40.0)], 10, "x")
    assert (block.begin, len(block.actions), block.change) == (0, 10, 40.0)


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


def played_by(player, asked):
    """What a player makes of these actions of a policy, tick after tick."""
    player.reset(None)
    return [player.step(None, Decision(Command.from_action(action), Trajectory.empty())) for action in asked]


def test_at_another_time_a_block_costs_what_it_cost_the_method():
    """A policy that accelerates is braked for less time, one that brakes by itself for longer."""
    player = BlockPlayer([Block(1, (-1.0, -1.0), 2.0)])
    found = played_by(player, [0.5] * 5)
    assert [repair.final_action for repair in found] == pytest.approx([0.5, -1.0, 0.0, 0.5, 0.5])
    assert sum(repair.change for repair in found) == pytest.approx(2.0)
    found = played_by(player, [-0.5] * 8)
    assert [repair.final_action for repair in found] == pytest.approx([-0.5, *[-1.0] * 4, *[-0.5] * 3])
    assert played_by(player, [-1.0, -1.0, -1.0, 1.0, 0.2])[3].final_action == -1.0


def test_where_blocks_overlap_the_harder_braking_counts_and_the_other_is_spent_afterwards():
    player = BlockPlayer([Block(0, (0.0,), 0.5), Block(0, (-1.0,), 1.5)])
    found = played_by(player, [0.5, 0.5, 0.5])
    assert [repair.final_action for repair in found] == pytest.approx([-1.0, 0.0, 0.5])


def test_the_dose_of_an_episode_is_the_methods_own_wherever_its_blocks_fall():
    case = min(corpus_of("modular").select("S3", "validation", violation=True), key=lambda case: case.duration)
    method = make_repairer("adreft", {"model": "modular"})
    result, blocks, _ = blocks_of(case.scenario(), make_policy("modular"), method)
    assert result.dose > 0.2
    again = []
    for number in range(3):
        moved = shuffled(blocks, round(case.duration / INTERVAL), f"{number}")
        again.append(run_episode(case.scenario(), make_policy("modular"), BlockPlayer(moved)))
    whole = [each.dose for each in again if each.outcome is not EventKind.COLLISION]  # a collision may cut it short
    assert whole
    assert whole == pytest.approx([result.dose] * len(whole))
    assert all(each.dose <= result.dose + 1e-6 for each in again)
