"""A rule that steps in only where a learned monitor foresees a collision as well.

A rival for ADReFT that has its prediction but not its choice of when and how: RSS and PredictiveBrake know what to do
about whoever is near, and are wrong mostly about whether anything will come of it. Whether an intervention is needed
it asks the model's need monitor, and lane changes it holds back by the change monitor, as ADReFT does.
"""

from collections.abc import Callable

from roadmend.core.command import Decision
from roadmend.core.repair import Proposal
from roadmend.core.route import Route
from roadmend.core.scene import Scene
from roadmend.networks.checkpoint import find_model
from roadmend.repair.adreft.change_gate import ChangeGate
from roadmend.repair.adreft.model import AdreftModel
from roadmend.repair.adreft.need_gate import NeedGate
from roadmend.repair.method import RepairMethod
from roadmend.repair.parameters import GatedParameters, PredictiveParameters, RssParameters
from roadmend.repair.predictive import PredictiveRepair
from roadmend.repair.rss import RssRepair

_RULES: dict[str, Callable[[GatedParameters], tuple[RepairMethod, ...]]] = {
    "rss": lambda given: (_rss(given),),
    "predictive": lambda given: (_predictive(given),),
    "both": lambda given: (_rss(given), _predictive(given)),
}


class GatedRepair:
    """Proposes what its rule proposes; of two rules that step in, the harder braking.

    Score: y_safe of the model where a rule steps in, else 0; threshold: the model's, or what was given instead,
    raised where nothing is needed.
    """

    name = "gated"

    def __init__(self, parameters: GatedParameters | None = None) -> None:
        """Load the model.

        Raises:
            InputError: there is no such model, or it does not fit this version of roadmend.
        """
        parameters = parameters or GatedParameters()
        self._model = AdreftModel.load(find_model(parameters.model, "adreft-"))
        self.model_digest = self._model.digest  # results are kept by it
        self._threshold = parameters.threshold if parameters.threshold >= 0.0 else self._model.threshold
        self._need = NeedGate(self._model, parameters.need_threshold)
        self._changes = ChangeGate(self._model, parameters.change_threshold)
        self._tokenizer = self._model.tokenizer()
        self._rules = _RULES[parameters.rule](parameters)

    def reset(self, route: Route) -> None:
        """Begin an episode on ``route``."""
        self._tokenizer.reset(route)
        self._need.reset()
        for rule in self._rules:
            rule.reset(route)

    def propose(self, scene: Scene, decision: Decision) -> Proposal:
        """Judge one tick."""
        tokens = self._tokenizer.tokens(scene, decision)  # at every tick: it remembers, and so do the rules
        score = self._model.score(self._model.encode(tokens.values), decision.command.action)
        proposed = [rule.propose(scene, decision) for rule in self._rules]
        stepping = [each for each in proposed if each.score > each.threshold]
        if not stepping:
            score = 0.0
        self._need.see(scene, decision, tokens)
        bar, needless = self._need.bar(score, self._threshold, self._threshold)
        if stepping:
            hardest = min(stepping, key=lambda each: each.action)
            proposal = Proposal(score, bar, hardest.action, hardest.triggers, needless or hardest.reason)
        else:
            proposal = Proposal(score, bar, decision.command.action)
        return self._changes.judge(proposal, tokens, scene) if decision.command.change_lane else proposal


def _rss(given: GatedParameters) -> RssRepair:
    return RssRepair(RssParameters(time_gap=given.time_gap, horizon=given.rss_horizon, full_brake=given.full_brake))


def _predictive(given: GatedParameters) -> PredictiveRepair:
    return PredictiveRepair(
        PredictiveParameters(horizon=given.horizon, margin=given.margin, adaptive=False, full_brake=given.full_brake)
    )
