"""A repairer that plays what it was told to, and nothing else; and what a policy's command comes to without a guard."""

from collections.abc import Sequence

from roadmend.core.command import Command, Decision
from roadmend.core.repair import Repair, played
from roadmend.core.route import Route
from roadmend.core.scene import Scene
from roadmend.repair.actions import ACTIONS
from roadmend.repair.guard import GuardedRepairer
from roadmend.repair.none import NoRepair
from roadmend.repair.sanitise import sanitise_command
from roadmend.training.adreft.trial_plan import Hold

_TICK = 1e-6  # [s] slack against rounding
_STOP_BRAKE = GuardedRepairer(NoRepair()).stop_brake


def valid_command(decision: Decision) -> Command:
    """The policy's command as the guard passes it on where it drives alone: one of a user's may be none."""
    return sanitise_command(decision.command, _STOP_BRAKE)


class HoldingRepairer:
    """Brakes as hard as its holds say while they last, where the policy brakes less (``core.interfaces.Repairer``)."""

    name = "holding"

    def __init__(self, holds: Sequence[Hold] = ()) -> None:
        self._holds = holds

    def reset(self, route: Route) -> None:
        """Begin an episode: nothing is remembered."""

    def step(self, scene: Scene, decision: Decision) -> Repair:
        """Play one tick."""
        command = valid_command(decision)
        now, asked = scene.time + _TICK, command.action
        wanted = next((ACTIONS[hold.action] for hold in self._holds if hold.begin <= now < hold.end), asked)
        return played(command, wanted)
