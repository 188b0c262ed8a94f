"""A governor: holds the ego at a share of the speed limit, whoever is there.

No repair, but what every repair must be held against: to drive slower saves some, and costs time everywhere.
"""

from roadmend.core.command import Decision
from roadmend.core.repair import Proposal
from roadmend.core.route import Route, RouteTracker
from roadmend.core.scene import Scene
from roadmend.repair.actions import ACTIONS
from roadmend.repair.parameters import GovernorParameters


class GovernorRepair:
    """Takes the throttle back, and brakes, in proportion to what the ego drives above a share of the speed limit.

    Score: the ego's speed over what it may drive, less 1; threshold: 0.
    """

    name = "governor"

    def __init__(self, parameters: GovernorParameters | None = None) -> None:
        self._parameters = parameters or GovernorParameters()
        self._tracker: RouteTracker | None = None

    def reset(self, route: Route) -> None:
        """Begin an episode on ``route``."""
        self._tracker = RouteTracker(route)

    def propose(self, scene: Scene, decision: Decision) -> Proposal:
        """Judge one tick.

        Raises:
            RuntimeError: no episode was begun.
        """
        del decision
        if self._tracker is None:
            raise RuntimeError("no episode was begun; call reset first")
        ego, parameters = scene.ego, self._parameters
        stage = self._tracker.observe(ego.x, ego.y)
        allowed = parameters.share * self._tracker.route.stages[stage].limit_at(self._tracker.places[stage][0])
        above = ego.speed - allowed
        action = max(-1.0, min(ACTIONS[0], -parameters.gain * above))
        reason = f"{ego.speed:.1f} m/s, {allowed:.1f} are allowed" if above > 0.0 else ""
        return Proposal(ego.speed / allowed - 1.0, 0.0, action, reason=reason)
