"""While the ego changes lanes, braking helps against whoever is ahead, and puts it in the way of whoever is behind.

A lane change takes a distance, not a time: an ego that is braked to a standstill in the middle of one stands across two
lanes, and is hit there.
"""

import math

from roadmend.core.jit import compiled, unnamed
from roadmend.core.route import Route, RouteTracker
from roadmend.core.scene import EgoState, Objects, Scene

ASIDE = 2.0  # [m] beside the ego's outline that still counts as ahead of it: the lane that it goes to, too
_CLOSE = 1.0  # [m] between bumpers: so near, it is there already
_ARRIVED = 0.3  # [m] from a lane's centre line
_BEGUN = 1.5  # [s] after which a change that was allowed to begin has left its lane


class LaneChange:
    """Follows the ego's lane changes and tells when braking would be for nobody ahead.

    Args:
        seconds: [s] within which somebody ahead is reached at today's speeds for whom braking is right, 0: always.
    """

    def __init__(self, seconds: float) -> None:
        self._seconds = seconds
        self._route: Route | None = None
        self._tracker: RouteTracker | None = None  # of the change under way
        self._from, self._since = 0, 0.0  # the stage that it leaves, and when it began [s]

    def reset(self, route: Route) -> None:
        """Begin an episode on ``route``."""
        self._route, self._tracker = route, None

    def see(self, scene: Scene) -> None:
        """Take in a tick; every one of them, in order."""
        if self._tracker is None:
            return
        self._tracker.observe(scene.ego.x, scene.ego.y)
        left, reached = (abs(offset) for _, offset in self._tracker.places[self._from : self._from + 2])
        stayed = left < _ARRIVED and not 0.0 <= scene.time - self._since < _BEGUN
        if reached < _ARRIVED or stayed:
            self._tracker = None

    def begin(self, scene: Scene) -> None:
        """The policy's wish to change lanes goes through at this tick; outside its window the vehicle ignores it."""
        if self._seconds <= 0.0 or self._route is None or self.is_under_way:
            return
        tracker, windows = RouteTracker(self._route), self._route.windows
        self._from, self._since = tracker.observe(scene.ego.x, scene.ego.y), scene.time
        if self._from >= len(windows):
            return
        position, _ = tracker.places[self._from]
        if windows[self._from].begin <= position <= windows[self._from].end:
            self._tracker = tracker

    @property
    def is_under_way(self) -> bool:
        """Whether the ego leaves its lane, or is between two."""
        return self._tracker is not None

    def is_clear_ahead(self, scene: Scene) -> bool:
        """Whether the ego changes lanes and braking it would be for nobody ahead."""
        return self.is_under_way and time_to_front(scene) > self._seconds


def time_to_front(scene: Scene) -> float:
    """Time [s] until the ego reaches the first who is ahead of it, at today's speeds; inf: nobody."""
    return float(_least_time(unnamed(scene.ego), scene.objects.table))


@compiled
def _least_time(ego: EgoState, objects: Objects) -> float:
    ego = EgoState(*ego)
    cosine, sine = math.cos(ego.yaw), math.sin(ego.yaw)
    least = math.inf
    for index in range(objects.shape[0]):
        other = objects[index]
        dx, dy = other.x - ego.x, other.y - ego.y
        along, aside = dx * cosine + dy * sine, dy * cosine - dx * sine
        if along <= 0.0 or abs(aside) >= 0.5 * (ego.width + other.width) + ASIDE:
            continue
        gap = along - 0.5 * (ego.length + other.length) - _CLOSE
        closing = ego.speed - other.speed * math.cos(other.yaw - ego.yaw)
        if gap <= 0.0:
            least = 0.0
        elif closing > 0.0:
            least = min(least, gap / closing)
    return least
