"""The dose-matched shuffle: a method's own braking, block by block, at random times before the impact.

Lane changes are held back as often and as long as the method did, whichever they are.

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


@dataclass(frozen=True, slots=True)
class Block:
    """Actions that were done in the place of the policy's, tick after tick."""

    begin: int  # tick
    actions: tuple[float, ...]

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

    waits = Waits()

    def watch(tick: Tick, decision: Decision, repair: Repair) -> None:
        waits.watch(asks=decision.command.change_lane, held=repair.held_back)
        if not repair.change:
            return
        if not begins or begins[-1] + len(actions[-1]) != tick.number:
            begins.append(tick.number)
            actions.append([])
        actions[-1].append(repair.final_action)

    result = run_episode(scenario, policy, repairer, watch)
    return result, [Block(begin, tuple(done)) for begin, done in zip(begins, actions, strict=True)], waits


def shuffled(blocks: Sequence[Block], until: int, seed: str) -> list[Block]:
    """The same blocks at times drawn uniformly from the ticks before ``until``, apart where there is room for all.

    Args:
        blocks: in any order; a longer one than there are ticks is cut.
        until: tick of the impact, or of the end.
        seed: of chance.
    """
    chance = random.Random(seed)
    placed: list[Block] = []
    for block in sorted(blocks, key=lambda each: (-len(each.actions), each.begin)):
        actions = block.actions[:until]
        for _ in range(_TRIES):
            moved = Block(chance.randrange(max(1, until - len(actions) + 1)), actions)
            if all(moved.end <= other.begin or other.end <= moved.begin for other in placed):
                break
        placed.append(moved)
    return placed


class BlockPlayer:
    """A repairer that plays blocks and looks at nothing; where the policy brakes harder, that is done."""

    name = "shuffle"

    def __init__(self, blocks: Sequence[Block], waits: WaitPlayer | None = None) -> None:
        """Where blocks overlap the harder braking counts."""
        self._waits = waits or WaitPlayer.idle()
        self._planned: dict[int, float] = {}
        for block in blocks:
            for tick, action in enumerate(block.actions, block.begin):
                self._planned[tick] = min(action, self._planned.get(tick, action))
        self._tick = 0

    def reset(self, route: Route) -> None:
        """Begin an episode."""
        del route
        self._tick = 0

    def step(self, scene: Scene, decision: Decision) -> Repair:
        """Play one tick."""
        del scene
        planned = self._planned.get(self._tick, 1.0)
        self._tick += 1
        repair = played(decision.command, planned)
        if not self._waits.holds(asks=decision.command.change_lane):
            return repair
        return repair.without_lane_change()
