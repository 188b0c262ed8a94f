"""Drives on which a change monitor learns: which lane changes were begun, and what came of them.

A policy that asks only where it sees room shows few changes that end badly. So some drives are of a careless driver, who
overlooks a share of those beside its lane until it asks; and in some of them requests are held back at random, so that
what comes of waiting is seen too. From its request on the driver sees everybody: what is learned is what a change leads to,
not what blindness does.
"""

import random
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from roadmend.core.array_file import ArrayRecord
from roadmend.core.command import Decision
from roadmend.core.fanout import Mapper
from roadmend.core.interfaces import Policy, Repairer
from roadmend.core.journal import entry_key, file_of
from roadmend.core.repair import Repair
from roadmend.core.route import Route
from roadmend.core.scene import Scene
from roadmend.policies.registry import make_policy
from roadmend.repair.adreft.registry import make_tokenizer
from roadmend.repair.adreft.tokenizer import Tokenizer, TokenSet
from roadmend.repair.registry import make_repairer
from roadmend.training.adreft.gathering import Recipe, gather_files
from roadmend.training.closed_loop import EpisodeCase
from roadmend.world.runner import drive
from roadmend.world.simulation import Simulation
from roadmend.world.variation import Spread

_BESIDE = 1.8  # [m] from the ego's axis on, others are beside its lane
_SHARES = (0.0, 0.3, 0.6)  # of requests held back, and of those beside that are overlooked; one is drawn for each drive


@dataclass(frozen=True, slots=True, eq=False)
class CaseChanges(ArrayRecord):
    """F lane changes that were begun in drives of one case, with M tokens of c attributes in all."""

    name: str  # of the case
    counts: NDArray[np.int32]  # tokens of each change, shape (F,)
    tokens: NDArray[np.float16]  # of the ticks at which they were asked for, shape (M, c)
    collided: NDArray[np.float32]  # 1 where the ego collided by its own fault within the horizon, else 0, shape (F,)

    def __len__(self) -> int:
        return len(self.counts)


@dataclass(frozen=True, slots=True)
class ChangePlan:
    """How a case is driven."""

    model: str  # name or file of the model of ADReFT that repairs the drives; its digest is part of their keys
    digest: str  # of that model
    drives: int  # of a case that a search has found: the first as it is, the others in worlds that differ
    horizon: float  # [s]
    plain: bool  # nobody is careless and nothing is held back: ordinary driving
    seed: int


class CarelessPolicy:
    """Overlooks some of those beside its lane until it asks for a lane change (``core.interfaces.Policy``)."""

    def __init__(self, policy: Policy, share: float, salt: int) -> None:
        self.name = policy.name
        self._policy, self._share, self._salt = policy, share, salt
        self._has_asked = False

    def reset(self, route: Route) -> None:
        """Begin an episode on ``route``."""
        self._policy.reset(route)
        self._has_asked = False

    def step(self, scene: Scene) -> Decision:
        """Decide for one tick."""
        objects, ego = scene.objects, scene.ego
        if self._share and not self._has_asked and len(objects):
            aside = (objects.y - ego.y) * np.cos(ego.yaw) - (objects.x - ego.x) * np.sin(ego.yaw)
            scattered = (objects.id.astype(np.uint64) * np.uint64(40503) + np.uint64(self._salt)) % np.uint64(997)
            seen = (np.abs(aside) < _BESIDE) | (scattered >= self._share * 997.0)
            scene = replace(scene, objects=objects.select(seen))
        decision = self._policy.step(scene)
        self._has_asked = self._has_asked or decision.command.change_lane
        return decision


class _Watch:
    """A repairer that holds lane changes back at random and keeps the tokens of those that it lets through."""

    def __init__(self, repairer: Repairer, tokenizer: Tokenizer, share: float, numbers: random.Random) -> None:
        self.name = repairer.name
        self._repairer, self._tokenizer, self._share, self._numbers = repairer, tokenizer, share, numbers
        self.begun: list[tuple[float, TokenSet]] = []  # [s]

    def reset(self, route: Route) -> None:
        """Begin an episode on ``route``."""
        self._repairer.reset(route)
        self._tokenizer.reset(route)

    def step(self, scene: Scene, decision: Decision) -> Repair:
        """Answer as the repairer does, but for what is held back."""
        tokens = self._tokenizer.tokens(scene, decision)
        repair = self._repairer.step(scene, decision)
        if not repair.command.change_lane:
            return repair
        if self._numbers.random() < self._share:
            return replace(repair, command=replace(repair.command, change_lane=False), intervened=True, held_back=True)
        self.begun.append((scene.time, tokens))
        return repair


def changes_of_case(case: EpisodeCase, recipe: Recipe, plan: ChangePlan) -> CaseChanges:
    """Drive one case in this process, under repair that holds nothing back by itself.

    Raises:
        InputError: the scenario or the model is unusable.
        SimulationError: SUMO failed.
    """
    policy = make_policy(recipe.policy)
    repairer = make_repairer("adreft", {"model": plan.model, "change_threshold": 1.0})
    found: list[tuple[TokenSet, float]] = []
    for number in range(plan.drives if case.digest else 1):
        numbers = random.Random(f"{plan.seed}:{case.name}:{number}")
        is_plain = plan.plain or (bool(case.digest) and number == 0)
        held, overlooked = (0.0, 0.0) if is_plain else (numbers.choice(_SHARES), numbers.choice(_SHARES))
        watch = _Watch(repairer, make_tokenizer(recipe.tokenizer), held, numbers)
        with Simulation(case.scenario()) as simulation:
            if number:
                simulation.vary(number, Spread())
            result = drive(simulation, CarelessPolicy(policy, overlooked, numbers.randrange(997)), watch)
        for time, tokens in watch.begun:
            found.append((tokens, float(result.final.at_fault and result.duration - time <= plan.horizon)))
    attributes = make_tokenizer(recipe.tokenizer).attributes
    return CaseChanges(
        case.name,
        np.array([len(tokens) for tokens, _ in found], dtype=np.int32),
        np.concatenate([np.empty((0, attributes)), *(tokens.values for tokens, _ in found)]).astype(np.float16),
        np.array([collided for _, collided in found], dtype=np.float32),
    )


def gather_changes(
    cases: Sequence[EpisodeCase],
    recipe: Recipe,
    plan: ChangePlan,
    cache: Path,
    mapper: Mapper,
    report: Callable[[CaseChanges], None] = lambda _changes: None,
) -> list[CaseChanges]:
    """Lane changes of every case, in the order of the cases; what lies in the cache is not driven again.

    Args:
        cases: what to drive.
        recipe: policy and tokenizer.
        plan: how.
        cache: folder with one file a case; an interruption costs the cases under way only.
        mapper: runs cases side by side.
        report: called for every case as soon as its changes are there.

    Raises:
        InputError: a case cannot be driven, or the cache cannot be written.
        SimulationError: SUMO failed, or a worker process died.
    """
    keyed = asdict(replace(plan, model=""))  # its digest tells it
    keys = [entry_key([__name__], key, keyed) for key in recipe.keys(cases)]
    places = [(case, file_of(cache, key, ".npz")) for case, key in zip(cases, keys, strict=True)]
    return gather_files(places, partial(changes_of_case, recipe=recipe, plan=plan), CaseChanges, mapper, report)
