"""The dose-matched shuffle: a method's own braking, block by block, at random times before the impact.

A block costs at another time what it cost the method: it is cut short once that dose is spent, for a policy that
accelerates there, and goes on with its last action until it is, for one that brakes by itself. Lane changes are held back
as often and as long as the method did, whichever they are.

What it fixes is what the amount of braking and of waiting does without its timing.
"""

import random
from collections.abc import Sequence
from dataclasses import dataclass

from harness.waits import WaitPlayer, Waits
from roadmend.core.command import Decision
from roadmend.core.episode_result import EpisodeResult
from roadmend.core.interfaces import Policy, Repairer
from roadmend.core.repair import Repair, played
from roadmend.core.route import Route
from roadmend.core.scene import Scene
from roadmend.core.tick import Tick
from roadmend.world.runner import run_episode
from roadmend.world.scenario import Scenario

_TRIES = 50  # places that are drawn for a block before it may overlap another
_SPENT = 1e-9  # of a block's change, what sums of floats leave over


@dataclass(frozen=True, slots=True)
class Block:
    """Actions that were done in the place of the policy's, tick after tick."""

    begin: int  # tick
    actions: tuple[float, ...]
    change: float  # sum over its ticks of |policy's action - final action|: its dose in ticks of full command

    @property
    def end(self) -> int:
        """The first tick after it."""
        return self.begin + len(self.actions)


def blocks_of(scenario: Scenario, policy: Policy, repairer: Repairer) -> tuple[EpisodeResult, list[Block], Waits]:
    """What a method makes of an episode, with which blocks, and which lane changes it held back.

    Raises:
        InputError: the scenario cannot be run.
        SimulationError: SUMO failed.
    """
    begins: list[int] = []
    actions: list[list[float]] = []
    changes: list[float] = []
    waits = Waits()

    def watch(tick: Tick, decision: Decision, repair: Repair) -> None:
        waits.watch(asks=decision.command.change_lane, held=repair.held_back)
        if not repair.change:
            return
        if not begins or begins[-1] + len(actions[-1]) != tick.number:
            begins.append(tick.number)
            actions.append([])
            changes.append(0.0)
        actions[-1].append(repair.final_action)
        changes[-1] += repair.change

    result = run_episode(scenario, policy, repairer, watch)
    found = zip(begins, actions, changes, strict=True)
    return result, [Block(begin, tuple(done), change) for begin, done, change in found], waits


def shuffled(blocks: Sequence[Block], until: int, seed: str) -> list[Block]:
    """The same blocks at times drawn uniformly from the ticks before ``until``, apart where there is room for all.

    Args:
        blocks: in any order; one that is longer than there are ticks begins at the first, and keeps its change.
        until: tick of the impact, or of the end.
        seed: of chance.
    """
    chance = random.Random(seed)
    placed: list[Block] = []
    for block in sorted(blocks, key=lambda each: (-len(each.actions), each.begin)):
        actions = block.actions[:until]
        for _ in range(_TRIES):
            moved = Block(chance.randrange(max(1, until - len(actions) + 1)), actions, block.change)
            if all(moved.end <= other.begin or other.end <= moved.begin for other in placed):
                break
        placed.append(moved)
    return placed


class BlockPlayer:
    """A repairer that plays blocks and looks at nothing; where the policy brakes harder, that is done."""

    name = "shuffle"

    def __init__(self, blocks: Sequence[Block], waits: WaitPlayer | None = None) -> None:
        """Where blocks overlap the harder braking counts, and the other one's change is spent afterwards."""
        self._waits = waits or WaitPlayer.idle()
        self._blocks = tuple(blocks)
        self._left = [block.change for block in blocks]
        self._tick = 0

    def reset(self, route: Route) -> None:
        """Begin an episode."""
        del route
        self._left = [block.change for block in self._blocks]
        self._tick = 0

    def step(self, scene: Scene, decision: Decision) -> Repair:
        """Play one tick."""
        del scene
        repair = played(decision.command, self._planned(decision.command.action))
        self._tick += 1
        if not self._waits.holds(asks=decision.command.change_lane):
            return repair
        return repair.without_lane_change()

    def _planned(self, asked: float) -> float:
        """The action of this tick, of which the block that it is of is told what it costs; 1 without a block."""
        due = [
            (block.actions[min(self._tick - block.begin, len(block.actions) - 1)], number)
            for number, block in enumerate(self._blocks)
            if block.begin <= self._tick and self._left[number] > _SPENT
        ]
        action, number = min(due, default=(1.0, -1))
        if action >= asked:
            return action
        left = self._left[number]
        if asked - action > left + _SPENT:
            action = asked - left
        self._left[number] = left - (asked - action)
        return action
