"""The decision merger (ADReFT section 3.1.4): the one place where a proposal may replace the policy's command."""

import math
from dataclasses import replace

from roadmend.core.command import Command
from roadmend.core.repair import Proposal


def proposal_fault(proposal: Proposal) -> str:
    """Why a proposal must not be merged, or an empty string.

    A comparison with NaN is false, so an unnoticed NaN would pass as 'safe'. NaN is therefore a fault in every field,
    with one exception: a method without any opinion says so with score and threshold NaN and the action 1, which no
    repair can have (the strongest action of a repair is 0.8).
    """
    action, score, threshold = proposal.action, proposal.score, proposal.threshold
    if math.isfinite(score) and math.isfinite(threshold):
        if -1.0 <= action <= 1.0:
            return ""
        return f"action {action:g} is outside -1..1"
    if action == 1.0 and math.isnan(score) and math.isnan(threshold):
        return ""
    return f"score {score:g} or threshold {threshold:g} is not finite"


def merge(command: Command, proposal: Proposal) -> Command:
    """The policy's own command object, or what is left of it.

    The proposed action takes the place of the policy's where the method steps in and it means less thrust; a lane change
    that the method holds back is not begun. The acceleration is never raised, and no lane change is begun that the policy
    has not asked for.

    Args:
        command: a valid command of the policy.
        proposal: a proposal in which ``proposal_fault`` finds nothing.
    """
    change_lane = command.change_lane and not proposal.hold_back
    if proposal.score > proposal.threshold and command.action > proposal.action:
        return Command.from_action(proposal.action, change_lane=change_lane)
    return command if change_lane == command.change_lane else replace(command, change_lane=change_lane)
