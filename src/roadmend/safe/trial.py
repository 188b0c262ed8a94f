"""One episode of a built scenario, with all that is needed to tell whether it was the crash of the report."""

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from roadmend.core.command import Decision
from roadmend.core.episode_result import EpisodeResult
from roadmend.core.errors import SimulationError
from roadmend.core.geometry import fill_corners
from roadmend.core.repair import Repair
from roadmend.core.route import Route
from roadmend.core.scene import EgoState, ObjectList
from roadmend.core.tick import Tick
from roadmend.policies.registry import make_policy
from roadmend.repair.registry import make_repairer
from roadmend.safe.dsl import Side
from roadmend.world.runner import drive
from roadmend.world.scenario import Scenario
from roadmend.world.simulation import Simulation

Floats = NDArray[np.float64]

_CORNER = 0.15  # share of a side's reach within which a contact counts for the neighbouring side too


@dataclass(frozen=True, slots=True)
class Contact:
    """How the ego and another vehicle touched, from the tick before they did.

    Attributes:
        name: of the other one.
        ego_sides: of the ego that were hit, two at a corner.
        other_sides: of the other one.
        angle: heading of the other one relative to the ego's [deg].
        ego_speed: [m/s].
        ego_front: [m] from the map's origin to the ego's front.
    """

    name: str
    ego_sides: frozenset[Side]
    other_sides: frozenset[Side]
    angle: float
    ego_speed: float
    ego_front: float


@dataclass(slots=True)
class Film:
    """Where everybody was, tick by tick."""

    ego: list[EgoState] = field(default_factory=list)
    objects: list[ObjectList] = field(default_factory=list)
    names: list[tuple[str, ...]] = field(default_factory=list)

    def track(self, name: str) -> Floats:
        """Tick, x and y [m] of one vehicle, N x 3."""
        rows = [
            (tick, objects.x[names.index(name)], objects.y[names.index(name)])
            for tick, (objects, names) in enumerate(zip(self.objects, self.names, strict=True))
            if name in names
        ]
        return np.array(rows).reshape(-1, 3)

    def nearest(self) -> int:
        """The tick at which somebody was nearest to the ego, or the middle of the episode if nobody was near."""
        gaps = [
            float(np.hypot(objects.x - ego.x, objects.y - ego.y).min()) if len(objects.x) else math.inf
            for ego, objects in zip(self.ego, self.objects, strict=True)
        ]
        best = int(np.argmin(gaps))
        return best if math.isfinite(gaps[best]) else len(gaps) // 2


@dataclass(frozen=True, slots=True)
class CrashTestEpisode:
    """What an episode came to."""

    summary: EpisodeResult
    film: Film
    route: Route
    contact: Contact | None


def run_trial(scenario: Scenario, policy: str) -> CrashTestEpisode:
    """Drive a scenario with a policy, without repair.

    Raises:
        InputError: the scenario cannot be run, or there is no such policy.
        SimulationError: SUMO failed, or the ego touches somebody before it moves.
    """
    film = Film()
    with Simulation(scenario) as simulation:

        def watch(tick: Tick, _decision: Decision, _repair: Repair) -> None:
            seen = simulation.seen
            assert seen is not None
            film.ego.append(tick.scene.ego)
            film.objects.append(seen.around)
            film.names.append(seen.names)

        summary = drive(simulation, make_policy(policy), make_repairer("none"), watch)
        route = simulation.route
    if not film.ego:
        raise SimulationError(f"{scenario.name} begins with a collision")
    hit = summary.final.object_names
    return CrashTestEpisode(summary, film, route, _contact(film, hit[0]) if hit else None)


def _contact(film: Film, name: str) -> Contact | None:
    """The contact with a vehicle; None if it came out of nowhere."""
    ego, objects, names = film.ego[-1], film.objects[-1], film.names[-1]
    if name not in names:
        return None
    index = names.index(name)
    other = (objects.x[index], objects.y[index], objects.yaw[index], objects.length[index], objects.width[index])
    own = (ego.x, ego.y, ego.yaw, ego.length, ego.width)
    on_ego, on_other = _nearest_points(own, other)
    angle = math.degrees(math.remainder(objects.yaw[index] - ego.yaw, math.tau))
    half = 0.5 * ego.length
    front = math.hypot(ego.x + half * math.cos(ego.yaw), ego.y + half * math.sin(ego.yaw))
    return Contact(name, _sides(own, on_ego), _sides(other, on_other), angle, ego.speed, front)


Box = tuple[float, float, float, float, float]  # x, y [m], yaw [rad], length, width [m]


def _nearest_points(one: Box, other: Box) -> tuple[Floats, Floats]:
    import shapely  # noqa: PLC0415 - only a collision needs it

    shapes = []
    for box in (one, other):
        corners = np.empty((4, 2))
        fill_corners(corners, *box)
        shapes.append(shapely.Polygon(corners))
    line = shapely.shortest_line(*shapes)
    points = shapely.get_coordinates(line)
    return points[0], points[-1]


def _sides(box: Box, point: Floats) -> frozenset[Side]:
    """The sides of an outline that a point on it belongs to."""
    x, y, yaw, length, width = box
    dx, dy = point[0] - x, point[1] - y
    ahead = (math.cos(yaw) * dx + math.sin(yaw) * dy) / (0.5 * length)
    left = (math.cos(yaw) * dy - math.sin(yaw) * dx) / (0.5 * width)
    along = {Side.FRONT} if ahead > 0.0 else {Side.REAR}
    across = {Side.LEFT} if left > 0.0 else {Side.RIGHT}
    if abs(abs(ahead) - abs(left)) < _CORNER:
        return frozenset(along | across)
    return frozenset(along if abs(ahead) > abs(left) else across)
