"""The paper's RuleRepair: time-to-collision to the object ahead on the planned path (ADReFT section 4.1)."""

import math

from roadmend.core.command import Decision
from roadmend.core.jit import compiled, unnamed
from roadmend.core.repair import Proposal, RepairTrigger
from roadmend.core.route import Route
from roadmend.core.scene import EgoState, Objects, Scene
from roadmend.repair.actions import braking_action
from roadmend.repair.parameters import RuleParameters
from roadmend.repair.planned_path import PathFinder, PlannedPath, coordinates_on


@compiled
def object_ahead(path: PlannedPath, ego: EgoState, objects: Objects, side_margin: float) -> tuple[int, float, float]:
    """The nearest of N objects in the ego's swath: index (-1: none), gap along the path [m], closing speed [m/s]."""
    path, ego = PlannedPath(*path), EgoState(*ego)
    found, least, closing = -1, math.inf, 0.0
    for index in range(objects.shape[0]):
        other = objects[index]
        s, d, turned = coordinates_on(path, other.x, other.y, other.yaw)
        cosine, sine = abs(math.cos(turned)), abs(math.sin(turned))
        half_length = 0.5 * (other.length * cosine + other.width * sine)
        half_width = 0.5 * (other.length * sine + other.width * cosine)
        beside = abs(d) > 0.5 * ego.width + half_width + side_margin
        if s <= 0.0 or s >= path.points[2, path.size - 1] or beside:
            continue
        gap = max(0.0, s - 0.5 * ego.length - half_length)
        if gap < least:
            found, least, closing = index, gap, ego.speed - other.speed * math.cos(turned)
    return found, least, closing


class RuleRepair:
    """Brakes where the time to collision with the object ahead is below a threshold; remembers nothing.

    Score: 1 / (1 + TTC), TTC in seconds, 0 where nothing closes in; threshold: the same of the TTC threshold. A
    trigger's weight is its score. The object ahead is the nearest one in the swath along the curved planned path.
    """

    name = "rule"

    def __init__(self, parameters: RuleParameters | None = None) -> None:
        self._parameters = parameters or RuleParameters()
        self._threshold = 1.0 / (1.0 + self._parameters.time_to_collision)
        self._idle = Proposal(0.0, self._threshold, 0.8)
        self._finder = PathFinder()

    def reset(self, route: Route) -> None:
        """Begin an episode on ``route``."""
        self._finder.reset(route)

    def propose(self, scene: Scene, decision: Decision) -> Proposal:
        """Judge the object ahead."""
        ego, objects, parameters = scene.ego, scene.objects, self._parameters
        if not len(objects):
            return self._idle
        path = self._finder.find(ego, decision.trajectory, 30.0 + ego.speed * parameters.time_to_collision)
        index, gap, closing = object_ahead(unnamed(path), unnamed(ego), objects.table, parameters.side_margin)
        if index < 0 or closing <= 0.0:
            return self._idle
        time = gap / closing
        score = 1.0 / (1.0 + time)
        if score <= self._threshold:
            return Proposal(score, self._threshold, 0.8)
        number = int(objects.id[index])
        needed = closing * closing / (2.0 * gap) if gap > 0.0 else math.inf
        action = -1.0
        if parameters.graded and math.isfinite(needed):
            action = min(-0.2, braking_action(needed, parameters.full_brake))
        reason = f"object {number} ahead: {gap:.1f} m, closing at {closing:.1f} m/s, {time:.1f} s to collision"
        return Proposal(score, self._threshold, action, (RepairTrigger(number, score),), reason)
