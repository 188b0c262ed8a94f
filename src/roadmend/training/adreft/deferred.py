"""A repairer whose choice of a moment is made for it; from then on it decides itself."""

from roadmend.core.command import Decision
from roadmend.core.interfaces import Repairer
from roadmend.core.repair import Repair, played
from roadmend.core.route import Route
from roadmend.core.scene import Scene
from roadmend.repair.actions import ACTIONS
from roadmend.training.adreft.holding import valid_command

_TICK = 1e-6  # [s] slack against rounding


class DeferredRepairer:
    """Plays one action, or leaves the policy alone, for a while; the repairer within sees all of it and then goes on."""

    name = "deferred"

    def __init__(self, within: Repairer, until: float, choice: int | None) -> None:
        """Stand before a repairer that is in the middle of an episode.

        Args:
            within: goes on afterwards.
            until: [s] simulation time.
            choice: index into ACTIONS of what is played where the policy brakes less; None leaves the policy alone.
        """
        self._within, self._until = within, until
        self._wanted = float("inf") if choice is None else ACTIONS[choice]

    def reset(self, route: Route) -> None:
        """Begin an episode on ``route``."""
        self._within.reset(route)

    def step(self, scene: Scene, decision: Decision) -> Repair:
        """Play one tick."""
        repair = self._within.step(scene, decision)  # at every tick: it remembers
        return played(valid_command(decision), self._wanted) if scene.time + _TICK < self._until else repair
