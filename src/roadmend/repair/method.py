"""What a repair method must offer; the guard around it copes with everything that goes wrong inside."""

from typing import Protocol

from roadmend.core.command import Decision
from roadmend.core.repair import Proposal
from roadmend.core.route import Route
from roadmend.core.scene import Scene


class RepairMethod(Protocol):
    """Looks at a scene and proposes an action; it neither merges nor sanitises, may raise and may be slow.

    The guard calls it with finite inputs only: a valid command, a trajectory that is either usable or empty, objects
    that are all usable, and stamps that grow from one call to the next until the next ``reset``.
    """

    name: str

    def reset(self, route: Route) -> None:
        """Begin an episode on ``route``, or begin anew in the middle of one; all memory is dropped."""

    def propose(self, scene: Scene, decision: Decision) -> Proposal:
        """Judge one tick.

        Raises:
            Exception: any; the guard then lets the RSS method decide the tick.
        """
