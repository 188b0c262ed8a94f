"""Drives on which a need monitor learns: where an intervention would begin, and what comes of it if nobody steps in."""

from roadmend.core.command import Decision
from roadmend.core.interfaces import Repairer
from roadmend.core.repair import Repair
from roadmend.core.route import Route
from roadmend.core.scene import Scene
from roadmend.networks.checkpoint import find_model
from roadmend.policies.registry import make_policy
from roadmend.repair.adreft.history import ATTRIBUTES, History
from roadmend.repair.adreft.model import AdreftModel
from roadmend.repair.adreft.tokenizer import TokenSet
from roadmend.repair.registry import make_repairer
from roadmend.training.adreft.case_risks import CaseRisks, RiskPlan, ended_badly, worlds_of
from roadmend.training.adreft.gathering import Recipe
from roadmend.training.closed_loop import EpisodeCase
from roadmend.world.runner import drive

LOWEST = 0.05  # score from which on an intervention may begin: far below any threshold that was ever of use
_EVERY = 3  # at most every so many-th tick of a drive is learned from; neighbours tell the same


class _CriticalTicks:
    """A repairer that repairs nothing and keeps ticks at which the model's state monitor finds the scene critical."""

    name = "none"

    def __init__(self, model: AdreftModel, repairer: Repairer, every: int, history: History | None) -> None:
        self._model, self._repairer, self._every, self._history = model, repairer, every, history
        self._tokenizer = model.tokenizer()
        self._rest = 0  # ticks until another one is kept
        self.kept: list[tuple[float, TokenSet]] = []  # [s]

    def reset(self, route: Route) -> None:
        """Begin an episode on ``route``."""
        self._repairer.reset(route)
        self._tokenizer.reset(route)
        if self._history is not None:
            self._history.reset()

    def step(self, scene: Scene, decision: Decision) -> Repair:
        """Let the decision pass."""
        tokens = self._tokenizer.tokens(scene, decision)
        if self._history is not None:
            self._history.see(scene, decision)
        score = self._model.score(self._model.encode(tokens.values), decision.command.action)
        self._rest -= 1
        if score > LOWEST and self._rest <= 0:
            self._rest = self._every
            if self._history is not None:
                tokens = TokenSet(self._history.extend(tokens), tokens.object_rows)
            self.kept.append((scene.time, tokens))
        return self._repairer.step(scene, decision)


def needs_of_case(case: EpisodeCase, recipe: Recipe, plan: RiskPlan) -> CaseRisks:
    """Drive one case without repair in this process. Of a plain drive every critical tick is kept.

    Raises:
        InputError: the scenario or the model is unusable.
        SimulationError: SUMO failed.
    """
    policy = make_policy(recipe.policy)
    model = AdreftModel.load(find_model(plan.model, "adreft-"))
    found: list[tuple[TokenSet, bool]] = []
    for _, simulation in worlds_of(case, plan):
        history = History() if plan.history else None
        watch = _CriticalTicks(model, make_repairer("none"), 1 if plan.plain else _EVERY, history)
        result = drive(simulation, policy, watch)
        found += [(tokens, ended_badly(result, time, plan.horizon)) for time, tokens in watch.kept]
    attributes = model.tokenizer().attributes + (ATTRIBUTES if plan.history else 0)
    return CaseRisks.of(case.name, found, attributes)
