"""Drives on which a change monitor learns: which lane changes were begun, and what came of them.

A policy that asks only where it sees room shows few changes that end badly. So some drives are of a careless driver, who
overlooks a share of those beside its lane until it asks; and in some of them requests are held back at random, so that
what comes of waiting is seen too. From its request on the driver sees everybody: what is learned is what a change leads to,
not what blindness does.
"""

import random
from dataclasses import replace

import numpy as np

from roadmend.core.command import Decision
from roadmend.core.interfaces import Policy, Repairer
from roadmend.core.repair import Repair
from roadmend.core.route import Route
from roadmend.core.scene import Scene
from roadmend.measures.answering import Answering
from roadmend.policies.registry import make_policy
from roadmend.repair.adreft.method import AdreftRepair
from roadmend.repair.adreft.registry import make_tokenizer
from roadmend.repair.adreft.tokenizer import Tokenizer, TokenSet
from roadmend.repair.guard import GuardedRepairer
from roadmend.repair.parameters import AdreftParameters
from roadmend.training.adreft.case_risks import CaseRisks, RiskPlan, ended_badly, worlds_of
from roadmend.training.adreft.gathering import Recipe
from roadmend.training.closed_loop import EpisodeCase
from roadmend.world.runner import drive

_BESIDE = 1.8  # [m] from the ego's axis on, others are beside its lane
_SHARES = (0.0, 0.3, 0.6)  # of requests held back, and of those beside that are overlooked; one is drawn for each drive


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


class _BegunChanges:
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
            return repair.without_lane_change()
        self.begun.append((scene.time, tokens))
        return repair


def changes_of_case(case: EpisodeCase, recipe: Recipe, plan: RiskPlan) -> CaseRisks:
    """Drive one case in this process, under repair that holds nothing back by itself.

    In a plain drive nobody is careless and nothing is held back.

    Raises:
        InputError: the scenario or the model is unusable.
        SimulationError: SUMO failed.
    """
    policy = make_policy(recipe.policy)
    # By its class, not by its name: so the code of the method is part of what these drives are kept by.
    repairer = Answering(GuardedRepairer(AdreftRepair(AdreftParameters(model=plan.model, change_threshold=1.0))))
    found: list[tuple[TokenSet, bool]] = []
    for number, simulation in worlds_of(case, plan):
        numbers = random.Random(f"{plan.seed}:{case.name}:{number}")
        is_plain = plan.plain or (bool(case.digest) and number == 0)
        held, overlooked = (0.0, 0.0) if is_plain else (numbers.choice(_SHARES), numbers.choice(_SHARES))
        watch = _BegunChanges(repairer, make_tokenizer(recipe.tokenizer), held, numbers)
        result = drive(simulation, CarelessPolicy(policy, overlooked, numbers.randrange(997)), watch)
        for time, tokens in watch.begun:
            found.append((tokens, ended_badly(result, time, plan.horizon)))
    return CaseRisks.of(case.name, found, make_tokenizer(recipe.tokenizer).attributes)
