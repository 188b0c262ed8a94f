"""Holds back the lane changes that a model's change monitor judges too dangerous."""

from dataclasses import replace

from roadmend.core.repair import Proposal
from roadmend.core.scene import Scene
from roadmend.repair.adreft.attention import attended
from roadmend.repair.adreft.model import AdreftModel
from roadmend.repair.adreft.tokenizer import TokenSet


class ChangeGate:
    """Adds to a proposal whether the lane change that the policy asks for must wait.

    Args:
        model: of ADReFT; without a change monitor nothing is held back.
        threshold: risk above which a change is held back; below 0 the model's own, from 1 on never.
    """

    def __init__(self, model: AdreftModel, threshold: float) -> None:
        self._monitor = model.change
        self.threshold = 1.0 if self._monitor is None else self._monitor.threshold(threshold)

    def judge(self, proposal: Proposal, tokens: TokenSet, scene: Scene) -> Proposal:
        """The proposal for a tick at which the policy asks for a lane change.

        Args:
            proposal: about its acceleration.
            tokens: of the tick.
            scene: of the tick.

        Raises:
            FloatingPointError: the risk is not finite.
        """
        if self._monitor is None or self.threshold >= 1.0:
            return proposal
        risk = self._monitor.risk(tokens.values)
        if risk <= self.threshold:
            return proposal
        reason = f"lane change held back: risk {risk:.3f} above {self.threshold:.3f}"
        reason = f"{proposal.reason}; {reason}" if proposal.reason else reason
        triggers = proposal.triggers or attended(self._monitor.attention, tokens, scene)
        return replace(proposal, hold_back=True, triggers=triggers, reason=reason)
