"""Responsibility-Sensitive Safety (Shalev-Shwartz, Shammah, Shashua 2017) as a repair method; also the rule guard."""

import numpy as np

from roadmend.core.command import Decision
from roadmend.core.jit import unnamed
from roadmend.core.repair import Proposal, RepairTrigger
from roadmend.core.route import RightOfWay, Route
from roadmend.core.scene import Scene, Signal
from roadmend.repair.latch import Latch
from roadmend.repair.parameters import RssParameters
from roadmend.repair.planned_path import PathFinder, PlannedPath
from roadmend.repair.rss_kernel import appraise
from roadmend.repair.rss_law import Law

RESTART = 1.0  # [m/s] during an intervention there must be room for at least this speed
KINDS = ("no concern", "ahead", "oncoming", "merging", "crossing")


def law_of(parameters: RssParameters, relief: float = 0.0) -> Law:
    """The constants of the formulas, with the time gap longer by the share ``relief``."""
    return Law(
        parameters.rho,
        parameters.a_max_accel,
        parameters.a_min_brake,
        max(parameters.a_max_brake, 0.1),
        parameters.a_lateral_accel,
        parameters.a_lateral_brake,
        parameters.mu,
        parameters.time_gap * (1.0 + relief),
        parameters.horizon,
    )


class RssRepair:
    """Responds properly, that is brakes, where a distance to somebody is less than the safe one.

    Along the planned path: to those ahead and to oncoming ones, if the lateral distance is unsafe too. Where ways
    merge: as if both were on one lane. Where they cross: if both would be there within a time gap, the ego stops
    before the shared ground, at the last moment at which the proper response still can; once it cannot, it clears the
    ground if it is first. Those behind see to themselves, and where the route gives the ego right of way (rule
    priority, or a green light) those are trusted who can still stop.

    Score: 1 - distance / safe distance, -1 .. 1, of the worst object; threshold: 0, and -``release`` during an
    intervention. Triggers are all objects above the threshold, weighed by their score. The action brakes as hard as
    the worst of them needs, at least with a_min_brake.
    """

    name = "rss"

    def __init__(self, parameters: RssParameters | None = None) -> None:
        self._parameters = parameters or RssParameters()
        self._law = law_of(self._parameters)
        self._held_law = law_of(self._parameters, self._parameters.release)
        self._finder = PathFinder()
        self._latch = Latch(self._parameters.hold, self._parameters.clear)
        self._route: Route | None = None
        self._zones = np.zeros((0, 2), dtype=np.float64)
        self._idle = Proposal(-1.0, 0.0, 0.8)

    def reset(self, route: Route) -> None:
        """Begin an episode on ``route``."""
        self._route = route
        self._zones = np.zeros((len(route.zones), 2), dtype=np.float64)
        self._finder.reset(route)
        self._latch.reset()

    def propose(self, scene: Scene, decision: Decision) -> Proposal:
        """Judge one tick."""
        proposal = self._appraise(scene, decision) if len(scene.objects) else self._idle
        return self._latch.settle(scene.time, proposal)

    def _appraise(self, scene: Scene, decision: Decision) -> Proposal:
        ego, objects, parameters = scene.ego, scene.objects, self._parameters
        held = self._latch.is_on
        speed = max(RESTART if held else 0.0, ego.speed)
        law = self._held_law if held else self._law
        threshold = -parameters.release if held else 0.0
        ahead = 30.0 + speed * (parameters.horizon + parameters.rho)
        path = self._finder.find(ego, decision.trajectory, ahead)
        zones = self._zones[: self._mark_zones(path, scene)]
        found = appraise(unnamed(path), zones, speed, unnamed(ego), objects.table, unnamed(law))
        scores = found[:, 1]
        worst = int(scores.argmax())
        score = float(scores[worst])
        if score <= threshold:
            return Proposal(score, threshold, 0.8)
        order = [int(index) for index in np.argsort(-scores, kind="stable") if scores[index] > threshold]
        triggers = tuple(RepairTrigger(int(objects.id[index]), float(scores[index])) for index in order)
        braking = max(float(found[index, 2]) for index in order)
        kind, distance, safe = KINDS[int(found[worst, 0])], found[worst, 3], found[worst, 4]
        reason = f"object {triggers[0].object_id} {kind}: {distance:.1f} m, safe are {safe:.1f} m"
        return Proposal(score, threshold, -min(1.0, braking / parameters.full_brake), triggers, reason)

    def _mark_zones(self, path: PlannedPath, scene: Scene) -> int:
        """Write the zones in which the ego goes first into the buffer, in path coordinates; returns their number."""
        number = 0
        for zone in self._route.zones if self._route else ():
            first = zone.rule == RightOfWay.PRIORITY or (
                zone.rule == RightOfWay.SIGNAL
                and 0 <= zone.signal < len(scene.signals)
                and scene.signals[zone.signal] == Signal.GREEN
            )
            if first and zone.stage >= path.stage:
                here = path.stage_positions[zone.stage]
                self._zones[number, 0], self._zones[number, 1] = zone.begin - here, zone.end - here
                number += 1
        return number
