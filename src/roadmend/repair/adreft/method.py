"""The repair method ADReFT: a trained model says when to step in and how gently (ADReFT section 3.1)."""

import random

import numpy as np
from numpy.typing import NDArray

from roadmend.core.command import Decision
from roadmend.core.repair import Proposal, RepairTrigger
from roadmend.core.route import Route
from roadmend.core.scene import Scene
from roadmend.networks.checkpoint import find_model
from roadmend.repair.actions import ACTIONS
from roadmend.repair.adreft.attention import attended
from roadmend.repair.adreft.change_gate import ChangeGate
from roadmend.repair.adreft.lane_change import LaneChange
from roadmend.repair.adreft.model import AdreftModel
from roadmend.repair.adreft.need_gate import NEVER, NeedGate
from roadmend.repair.adreft.opening import Opening
from roadmend.repair.adreft.patience import STANDING, Patience
from roadmend.repair.latch import Latch
from roadmend.repair.parameters import AdreftParameters


class AdreftRepair:
    """Proposes the action of greatest value; steps in where the score is above the threshold.

    An intervention begins only where it is needed, where its model has a monitor of that. Lane changes whose risk is above
    a threshold of their own it holds back, where its model has a monitor of them; during one it brakes for those ahead alone,
    where its model says so.
    Score: y_safe, or how due an intervention is by its worth where that is more; threshold: lambda_safe of the model,
    or what was given instead, raised where patience has ended or nothing is needed. A trigger's weight is the share of
    attention that the participant's tokens drew in the encoder's last layer.
    """

    name = "adreft"

    def __init__(
        self, parameters: AdreftParameters | None = None, seed: int = 0, model: AdreftModel | None = None
    ) -> None:
        """Load the model.

        Args:
            parameters: which model, and with which threshold.
            seed: of a model that chooses at random.
            model: one that is loaded already, instead.

        Raises:
            InputError: there is no such model, or it does not fit this version of roadmend.
        """
        parameters = parameters or AdreftParameters()
        self.model = model or AdreftModel.load(find_model(parameters.model, "adreft-"))
        self.threshold = parameters.threshold if parameters.threshold >= 0.0 else self.model.threshold
        self._need = NeedGate(self.model, parameters.need_threshold)
        self._changes = ChangeGate(self.model, parameters.change_threshold)
        self._tokenizer = self.model.tokenizer()
        self._seed = seed
        self._numbers = random.Random(f"{seed}:")
        configuration = self.model.configuration
        self._latch = Latch(configuration.hold, configuration.clear)
        self._opening = Opening(configuration.opening)
        self._patience = Patience(configuration.longest, configuration.standstill)
        self._lane_change = LaneChange(configuration.lane_change)
        self._held = 0  # ticks for which the last choice has held, 0 where it is time for another
        self._action = ACTIONS[0]

    def reset(self, route: Route) -> None:
        """Begin an episode on ``route``."""
        self._tokenizer.reset(route)
        self._latch.reset()
        self._opening.reset()
        self._patience.reset()
        self._need.reset()
        self._lane_change.reset(route)
        self._held, self._action = 0, ACTIONS[0]
        self._numbers.seed(f"{self._seed}:{route.scenario}")

    def propose(self, scene: Scene, decision: Decision) -> Proposal:
        """Judge one tick.

        Raises:
            FloatingPointError: the model's values are not finite.
        """
        tokens, asked = self._tokenizer.tokens(scene, decision), decision.command.action
        state = self.model.encode(tokens.values)
        score = self.model.score(state, asked)
        values = self.model.values(state, asked)
        if not np.isfinite(values).all():
            raise FloatingPointError("the decision adapter's values are not finite")
        alarmed = score > self.threshold
        score = max(score, self.model.due(values, asked, scene))
        self._need.see(scene, decision, tokens)
        self._lane_change.see(scene)
        bar, needless = self._need.bar(score, self.threshold, self._patience.bar(score, self.threshold))
        if score > bar and self._lane_change.is_clear_ahead(scene):
            bar, needless = NEVER, f"criticality {score:.3f}, but the ego changes lanes and nobody is close ahead"
        configuration = self.model.configuration
        if self._held == 0 or (configuration.fresh and score > bar and not self._latch.is_on):
            self._action, self._held = ACTIONS[self._choose(values, asked)], 0
        self._held = (self._held + 1) % configuration.interval
        triggers: tuple[RepairTrigger, ...] = ()
        reason = needless
        if self._patience.has_ended:
            reason = f"let go until the score falls to {self.threshold:.3f}"
        action = self._opening.action(scene.time, self._action, is_due=score > bar)
        how = ""
        if score > bar:
            triggers = attended(self.model.attention, tokens, scene)
            what = "criticality" if alarmed else "precaution: worth"
            reason = f"{what} {score:.3f} above {bar:.3f}"
            risk = self._need.pressing_risk()
            if risk is not None:
                action, how = ACTIONS[-1], f"; braking in full: risk {risk:.3f}"
            elif action < self._action:
                how = "; braking in full at first"
        # An ego that stands stays where it is, however hard the brakes are pressed.
        if scene.ego.speed < STANDING and action < configuration.holding:
            action, how = configuration.holding, "; held where it stands" if score > bar else ""
        worth = self.model.worth(values, asked, ACTIONS.index(action))
        proposal = Proposal(score, bar, action, triggers, reason + how, worth)
        if configuration.fresh and action >= asked:
            self._latch.reset()  # the adapter, or the policy by braking itself, has ended it
            self._held = 0
        else:
            proposal = self._latch.settle(scene.time, proposal)
        self._patience.watch(scene, intervenes=proposal.score > proposal.threshold and asked > proposal.action)
        if decision.command.change_lane:
            proposal = self._changes.judge(proposal, tokens, scene)
            if not proposal.hold_back:
                self._lane_change.begin(scene)
        return proposal

    def _choose(self, values: NDArray[np.float32], asked: float) -> int:
        """Index of the action to propose where the policy asks for ``asked``."""
        configuration = self.model.configuration
        if configuration.choice == "random":
            return self._numbers.randrange(len(ACTIONS))
        best = int(values.argmax())
        if configuration.margin > 0.0:
            idle = max(
                (value for value, action in zip(values, ACTIONS, strict=True) if action >= asked), default=values[0]
            )
            if values[best] <= idle + configuration.margin:
                return 0
        return best
