"""The reward, term by term: what each is worth can be set, and what each came to is told at every step."""

from pydantic import Field

from roadmend.core.outcome import EventKind
from roadmend.core.parameters import Parameters
from roadmend.core.tick import INTERVAL, Tick


class RewardWeights(Parameters):
    """What each term is worth; a term whose weight is 0 counts nothing."""

    progress: float = Field(0.05, description="for each metre of the route that was driven towards the goal")
    time: float = Field(-0.1, description="for each second")
    speeding: float = Field(-0.2, description="for each second, times the speed above the limit [m/s]")
    change: float = Field(-0.05, description="for the change of throttle - brake since the last tick, 0 .. 2")
    goal: float = Field(10.0, description="for reaching the goal")
    collision: float = Field(-10.0, description="for a collision, whosever fault it is")
    fault: float = Field(-10.0, description="for a collision by the ego's own fault, on top")
    off_route: float = Field(-10.0, description="for driving on where the lane ends")


def reward_terms(
    weights: RewardWeights, tick: Tick, driven: float, speed_limit: float, action_change: float
) -> dict[str, float]:
    """The terms of one step, by name; the reward is their sum.

    Args:
        weights: what each is worth.
        tick: that the step came to.
        driven: way towards the goal [m].
        speed_limit: where the ego is [m/s].
        action_change: of throttle - brake since the last tick, 0 .. 2.
    """
    final = tick.final.kind if tick.final is not None else None
    is_at_fault = tick.final is not None and tick.final.at_fault
    return {
        "progress": weights.progress * driven,
        "time": weights.time * INTERVAL,
        "speeding": weights.speeding * INTERVAL * max(0.0, tick.scene.ego.speed - speed_limit),
        "change": weights.change * action_change,
        "goal": weights.goal * (final is EventKind.GOAL),
        "collision": weights.collision * (final is EventKind.COLLISION),
        "fault": weights.fault * is_at_fault,
        "off_route": weights.off_route * (final is EventKind.OFF_ROUTE),
    }
