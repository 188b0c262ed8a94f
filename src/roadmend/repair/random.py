"""The paper's Random baseline: a random action at random ticks (ADReFT section 4.1)."""

import random

from roadmend.core.command import Decision
from roadmend.core.repair import Proposal
from roadmend.core.route import Route
from roadmend.core.scene import Scene
from roadmend.repair.actions import ACTIONS
from roadmend.repair.parameters import RandomParameters


class RandomRepair:
    """With a fixed probability per tick proposes a uniformly random action of the repair action space.

    Score: 1 - u of a uniform number u in [0, 1); threshold: 1 - probability. A reset seeds anew with the seed and the
    scenario's name, so an episode is reproducible whatever ran before it.
    """

    name = "random"

    def __init__(self, parameters: RandomParameters | None = None, seed: int = 0) -> None:
        parameters = parameters or RandomParameters()
        self._threshold = 1.0 - parameters.probability
        self._seed = seed
        self._numbers = random.Random(f"{seed}:")

    def reset(self, route: Route) -> None:
        """Seed anew for the scenario."""
        self._numbers.seed(f"{self._seed}:{route.scenario}")

    def propose(self, scene: Scene, decision: Decision) -> Proposal:
        """Draw the tick's score and action; the same number of draws whatever they are."""
        del scene, decision
        score = 1.0 - self._numbers.random()
        action = ACTIONS[self._numbers.randrange(len(ACTIONS))]
        return Proposal(score, self._threshold, action, reason=f"drew {score:.3f} against {self._threshold:g}")
