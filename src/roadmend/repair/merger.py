"""The decision merger (ADReFT section 3.1.4): the one place where a proposal may replace the policy's command."""

import math
from dataclasses import replace
from operator import index
from typing import Any

import numpy as np

from roadmend.core.command import Command
from roadmend.core.foreign import is_text
from roadmend.core.repair import Proposal

LAST_ID = 2**32 - 1  # the greatest number of an object that a message holds


def proposal_fault(proposal: Proposal) -> str:
    """Why a proposal must not be merged, or an empty string.

    A comparison with NaN is false, so an unnoticed NaN would pass as 'safe'. NaN is therefore a fault in every field,
    with one exception: a method without any opinion says so with score and threshold NaN and the action 1, which no
    repair can have (the strongest action of a repair is 0.8).

    So is what no message can hold: once the answer is under way, it would end the node that sends it.
    """
    action, score, threshold = proposal.action, proposal.score, proposal.threshold
    if math.isfinite(score) and math.isfinite(threshold):
        if not -1.0 <= action <= 1.0:
            return f"action {action:g} is outside -1..1"
    elif not (action == 1.0 and math.isnan(score) and math.isnan(threshold)):
        return f"score {score:g} or threshold {threshold:g} is not finite"
    return _account_fault(proposal)


def _account_fault(proposal: Any) -> str:
    """Why what a proposal tells beside its action cannot be passed on, or an empty string."""
    if not isinstance(proposal.triggers, tuple | list):
        return f"triggers are no tuple but of type {type(proposal.triggers).__name__}"
    for at, trigger in enumerate(proposal.triggers):
        if not _is_trigger(trigger):
            return f"triggers[{at}] is no RepairTrigger with a number 0..{LAST_ID} and a finite weight"
    if proposal.worth is not None and not _is_finite(proposal.worth):
        return "worth is neither None nor a finite number"
    if not isinstance(proposal.hold_back, bool | np.bool_):
        return "hold_back is neither True nor False"
    return "" if is_text(proposal.reason) else "reason is no text that UTF-8 can hold"


def _is_trigger(value: Any) -> bool:
    try:
        return 0 <= index(value.object_id) <= LAST_ID and _is_finite(value.weight)
    except (AttributeError, TypeError):
        return False


def _is_finite(value: Any) -> bool:
    try:
        return math.isfinite(value)
    except (TypeError, ValueError, OverflowError):
        return False


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
        return Command.from_action(float(proposal.action), change_lane=change_lane)
    return command if change_lane == command.change_lane else replace(command, change_lane=change_lane)
