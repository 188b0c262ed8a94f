"""The repair method that never steps in: the policy as it is."""

import math

from roadmend.core.command import Decision
from roadmend.core.repair import Proposal
from roadmend.core.route import Route
from roadmend.core.scene import Scene

NO_OPINION = Proposal(math.nan, math.nan, 1.0)


class NoRepair:
    """Has neither score nor threshold. The guard around it still sanitises commands and drops unusable objects."""

    name = "none"

    def reset(self, route: Route) -> None:
        """Nothing is remembered."""

    def propose(self, scene: Scene, decision: Decision) -> Proposal:
        """Never steps in."""
        del scene, decision
        return NO_OPINION
