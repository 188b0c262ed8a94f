"""A repairer that plays what it was told to, and nothing else."""

from collections.abc import Sequence

from roadmend.core.command import Command, Decision
from roadmend.core.repair import Repair, RepairStatus
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
        now, command = scene.time + _TICK, decision.command
        asked = command.action
        wanted = next((ACTIONS[hold.action] for hold in self._holds if hold.begin <= now < hold.end), asked)
        if wanted >= asked:
            return Repair(command, RepairStatus.PASS, 0.0, 0.5, asked, wanted, intervened=False)
        final = Command.from_action(wanted, change_lane=command.change_lane)
        return Repair(final, RepairStatus.REPAIRED, 1.0, 0.5, asked, wanted, intervened=True)
