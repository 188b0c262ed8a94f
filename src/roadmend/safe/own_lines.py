"""Lines [m] for vehicles that leave the lanes: a U-turn, and a way backwards."""

import math

from roadmend.core.route import Stage
from roadmend.world.steering import line_through

_RADIUS = 6.0  # [m] of a U-turn, near full lock
_STEP = math.radians(10.0)  # between two points of an arc
_RUN = 4.0  # [m] straight on before a U-turn
_AWAY = 60.0  # [m] that it goes on after it
_BACK = 40.0  # [m] at most backwards

Points = list[tuple[float, float]]


def u_turn_line(lane: Points, start: float) -> Points:
    """From a place on a lane [m along it] round to the left, and away in the other direction."""
    line = line_through(lane)
    x, y, heading = line.pose(start)
    points = [(x, y), _ahead(x, y, heading, _RUN)]
    x, y = points[-1]
    centre = x - _RADIUS * math.sin(heading), y + _RADIUS * math.cos(heading)
    for step in range(1, round(math.pi / _STEP) + 1):
        angle = heading - 0.5 * math.pi + step * _STEP
        points.append((centre[0] + _RADIUS * math.cos(angle), centre[1] + _RADIUS * math.sin(angle)))
    points.append(_ahead(*points[-1], heading + math.pi, _AWAY))
    return _rounded(points)


def backwards_line(lane: Points, start: float) -> Points:
    """From a place on a lane [m along it] back along it."""
    line: Stage = line_through(lane)
    places = [start - 5.0 * step for step in range(round(_BACK / 5.0) + 1) if start - 5.0 * step >= 0.0]
    return _rounded([line.pose(place)[:2] for place in places])


def _ahead(x: float, y: float, heading: float, distance: float) -> tuple[float, float]:
    return x + distance * math.cos(heading), y + distance * math.sin(heading)


def _rounded(points: Points) -> Points:
    return [(round(float(x), 3), round(float(y), 3)) for x, y in points]
