"""The four measures of Bench2Drive (Jia et al. 2024, section 4) of one episode.

Driving Score is route completion times infraction penalty, Success that the goal was reached without an infraction,
Efficiency the ego's speed against that of the traffic around it, Comfortness as ``measures.comfort`` has it.

The factors are those of Bench2Drive's leaderboard. It knows more infractions than this world: running a stop sign, not
yielding to an emergency vehicle, scenario time-outs and static obstacles are not looked for here. A collision ends the
episode here and does not there, so that it costs the rest of the route besides its factor. As there, a collision of any
blame counts unless the ego stood; whose fault it is by nuPlan's rules is said beside it. A time-out and the end of the
lane cost what is left of the route, and no factor.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from roadmend.core.outcome import Blame, Event, EventKind
from roadmend.core.route import RightOfWay, Route
from roadmend.core.scene import ObjectKind, Scene, Signal
from roadmend.measures.comfort import comfort
from roadmend.measures.route_progress import RoutePlace, RouteProgress

PENALTIES = {"collision_pedestrian": 0.5, "collision_vehicle": 0.6, "red_light": 0.7}
CHECKPOINTS = 20  # stretches of the route over which speeds are compared, as Bench2Drive has it
RATIO_MAX = 1000.0  # [%] a stretch beyond it says that the traffic stood, and is left out, as Bench2Drive does


@dataclass(frozen=True, slots=True)
class DrivingMeasures:
    """The measures of one episode."""

    outcome: str  # an EventKind's name
    route_completion: float  # [%]
    infractions: tuple[str, ...]  # names from PENALTIES, one for each time
    driving_score: float  # 0 .. 100
    success: bool
    efficiency: float | None  # [%] of the traffic's speed; None where nobody drove around the ego
    comfortness: float | None  # [%] of the pieces; None for a drive too short to tell
    at_fault: bool  # whether it ended in a collision by the ego's own fault

    @classmethod
    def parse(cls, content: Mapping[str, Any]) -> Self:
        """From plain values, as ``dataclasses.asdict`` and JSON give them."""
        return cls(**{**content, "infractions": tuple(content["infractions"])})


class MeasuresObserver:
    """Sees every scene of an episode, the final one too, and tells the measures."""

    def __init__(self, route: Route) -> None:
        self._route = route
        self._progress = RouteProgress(route)
        self._place: RoutePlace | None = None
        self._infractions: list[str] = []
        self._motion: list[tuple[float, float, float]] = []  # time [s], speed [m/s], yaw rate [rad/s]
        self._stretches: dict[int, list[tuple[float, float]]] = {}  # ego's and traffic's speed [m/s] tick by tick
        self._kinds: dict[int, int] = {}  # of everybody ever seen

    def see(self, scene: Scene) -> None:
        """Take in one tick."""
        ego, objects = scene.ego, scene.objects
        place = self._progress.observe(ego)
        self._motion.append((scene.time, ego.speed, ego.yaw_rate))
        driving = objects.speed[objects.kind != ObjectKind.PEDESTRIAN]
        if len(driving):
            stretch = min(CHECKPOINTS - 1, int(CHECKPOINTS * self._progress.completion(place)))
            self._stretches.setdefault(stretch, []).append((ego.speed, float(np.mean(driving))))
        self._kinds.update(zip(objects.id.tolist(), objects.kind.tolist(), strict=True))
        if self._place is not None and self._runs_red(self._place, place, scene):
            self._infractions.append("red_light")
        self._place = place

    def measures(self, final: Event) -> DrivingMeasures:
        """The measures of the episode that was seen and that ended with this event."""
        infractions = [*self._infractions]
        outcome = final.kind
        if outcome == EventKind.COLLISION and final.blame != Blame.EGO_STOOD:
            kind = self._kinds.get(next(iter(final.object_ids), -1))
            infractions.append("collision_pedestrian" if kind == ObjectKind.PEDESTRIAN else "collision_vehicle")
        completion = 1.0 if outcome == EventKind.GOAL else self._completion()
        penalty = float(np.prod([PENALTIES[name] for name in infractions]))
        smooth = comfort(*(list(column) for column in zip(*self._motion, strict=True))) if self._motion else None
        return DrivingMeasures(
            outcome.name,
            100.0 * completion,
            tuple(infractions),
            100.0 * completion * penalty,
            outcome == EventKind.GOAL and not infractions,
            self._efficiency(),
            None if smooth is None else 100.0 * smooth,
            final.at_fault,
        )

    def _completion(self) -> float:
        return 0.0 if self._place is None else self._progress.completion(self._place)

    def _efficiency(self) -> float | None:
        ratios = []
        for ticks in self._stretches.values():
            own, others = (float(np.mean(column)) for column in zip(*ticks, strict=True))
            if others > 0.0 and 100.0 * own / others <= RATIO_MAX:
                ratios.append(100.0 * own / others)
        return float(np.mean(ratios)) if ratios else None

    def _runs_red(self, before: RoutePlace, now: RoutePlace, scene: Scene) -> bool:
        """Whether the ego's front passes a stop line at this tick while the light is red."""
        half = 0.5 * self._route.ego_length
        return before.stage == now.stage and any(
            zone.rule == RightOfWay.SIGNAL
            and zone.stage == now.stage
            and before.position + half <= zone.begin < now.position + half
            and 0 <= zone.signal < len(scene.signals)
            and scene.signals[zone.signal] == Signal.RED
            for zone in self._route.zones
        )
