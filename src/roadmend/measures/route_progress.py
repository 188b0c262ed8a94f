"""Where on its route the ego is, from its poses alone: what a bag tells as well as a simulation."""

from dataclasses import dataclass

from roadmend.core.route import Route, RouteTracker, Zone
from roadmend.core.scene import EgoState


@dataclass(frozen=True, slots=True)
class RoutePlace:
    """A point of the route."""

    stage: int  # the nearest
    position: float  # [m] arc length on it
    offset: float  # [m] from its centre line, left positive

    def ahead(self, zone: Zone) -> float:
        """Way [m] to a zone of the same stage: negative inside and behind it."""
        return zone.begin - self.position


class RouteProgress:
    """Follows the ego along its route; fed with its poses in their order, since a route may cross itself."""

    def __init__(self, route: Route) -> None:
        self._route = route
        self._tracker = RouteTracker(route)
        self._whole = 0.0  # [m] left at the start

    def observe(self, ego: EgoState) -> RoutePlace:
        """Take in the next pose."""
        nearest = self._tracker.observe(ego.x, ego.y)
        place = RoutePlace(nearest, *self._tracker.places[nearest])
        if not self._whole:
            self._whole = self.left(place)
        return place

    def completion(self, place: RoutePlace) -> float:
        """Share of the route that lies behind a place, 0 .. 1."""
        return min(1.0, max(0.0, 1.0 - self.left(place) / self._whole)) if self._whole > 0.0 else 1.0

    def left(self, place: RoutePlace) -> float:
        """Way [m] from a place to the goal; each lane change as soon as its window is open."""
        way, position = 0.0, place.position
        for index in range(place.stage, len(self._route.windows)):
            begin = max(position, self._route.windows[index].begin)
            way += begin - position
            x, y, _ = self._route.stages[index].pose(begin)
            after = self._route.stages[index + 1]
            position, _ = after.project(x, y, 0.5 * after.length, after.length)
        return max(0.0, way + self._route.goal - position)
