"""A repairer that plays what it was told to, and nothing else."""

from collections.abc import Sequence

from roadmend.core.command import Decision
from roadmend.core.repair import Repair, played
from roadmend.core.route import Route
from roadmend.core.scene import Scene
from roadmend.repair.actions import ACTIONS
from roadmend.training.adreft.trial_plan import Hold

_TICK = 1e-6  # [s] slack against rounding


class HoldingRepairer:
    """Brakes as hard as its holds say while they last, where the policy brakes less (``core.interfaces.Repairer``)."""

    name = "holding"

    def __init__(self, holds: Sequence[Hold] = ()) -> None:
        self._holds = holds

    def reset(self, route: Route) -> None:
        """Begin an episode: nothing is remembered."""

    def step(self, scene: Scene, decision: Decision) -> Repair:
        """Play one tick."""
        now, asked = scene.time + _TICK, decision.command.action
        wanted = next((ACTIONS[hold.action] for hold in self._holds if hold.begin <= now < hold.end), asked)
        return played(decision.command, wanted)
