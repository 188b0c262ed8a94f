"""A repair method that is believed only where it answers: figures are of what it did, not of what the guard did for it."""

from roadmend.core.command import Decision
from roadmend.core.errors import RoadmendError
from roadmend.core.repair import Repair
from roadmend.core.route import Route
from roadmend.core.scene import Scene
from roadmend.repair.guard import GuardedRepairer


class Answering:
    """A method behind its guard, for drives from which figures are made. Unlike other repairers it raises.

    Where a method fails, the guard's rule drives on, which may well end better than the method would have.
    """

    def __init__(self, guarded: GuardedRepairer) -> None:
        self.name = guarded.name
        self._guarded = guarded

    def reset(self, route: Route) -> None:
        """Begin an episode on ``route``."""
        self._guarded.reset(route)

    def step(self, scene: Scene, decision: Decision) -> Repair:
        """Check one decision and repair it where needed.

        Raises:
            RoadmendError: the method could not answer.
        """
        repair = self._guarded.step(scene, decision)
        if self._guarded.first_fault:
            raise RoadmendError(self._guarded.first_fault)
        return repair
