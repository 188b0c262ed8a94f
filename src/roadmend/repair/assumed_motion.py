"""What repair assumes where nobody tells a planned trajectory: the ego goes on as it moves at present."""

import math
from enum import StrEnum

import numpy as np

from roadmend.core.command import Command, Decision, Trajectory
from roadmend.core.geometry import wrap_angle
from roadmend.core.route import Route, RouteTracker, Stage
from roadmend.core.scene import EgoState
from roadmend.repair.planned_path import ON_ROUTE, PathFinder, pose_at

INTERVAL = 0.25  # [s] between two points, that of the policies here
POINTS = 20  # 5 s ahead
ALONG = math.pi / 3.0  # [rad] an ego that points farther away from its lane than this does not drive along it
NOWHERE = -5e7  # [m] where no ego ever is, and still exact enough for a double


class Assumption(StrEnum):
    """How the ego is taken to go on; the value is a note for people."""

    ALONG_ROUTE = "no planned trajectory: the present speed along the route is assumed"
    PRESENT_TURN = "no planned trajectory: the present speed and turn are assumed"


class AssumedMotion:
    """Makes the trajectory that nobody told: 5 s at the present speed.

    Along the route, back to its lane's centre within 20 m, where the ego is on it (no more than 5 m and 60 degrees
    away); elsewhere on the circle of its present yaw rate. Speed never changes: what the ego is about to do is unknown,
    and a method that brakes for the assumed motion brakes for an ego that ignores what is ahead.
    """

    def __init__(self) -> None:
        self._route: Route | None = None
        self._tracker: RouteTracker | None = None
        self._finder = PathFinder()
        self.assumption = Assumption.PRESENT_TURN  # behind the last trajectory

    def reset(self, route: Route | None) -> None:
        """Begin an episode, on ``route`` if there is one."""
        self._route = None if route is None or is_open(route) else route
        self._tracker = None if self._route is None else RouteTracker(self._route)
        if self._route is not None:
            self._finder.reset(self._route)

    def decide(self, ego: EgoState, command: Command) -> Decision:
        """The command with the trajectory that is assumed behind it.

        Args:
            ego: finite or not; where it is not, the trajectory is empty.
            command: the policy's, as it was given.
        """
        return Decision(command, self.trajectory(ego))

    def trajectory(self, ego: EgoState) -> Trajectory:
        """Shape (POINTS,), frame map; empty where the ego's state is not finite. To be called once a tick."""
        if not math.isfinite(ego.x + ego.y + ego.yaw + ego.speed + ego.yaw_rate):
            return Trajectory.empty()
        speed = max(0.0, ego.speed)
        if self._is_on_route(ego):
            self.assumption = Assumption.ALONG_ROUTE
            path = self._finder.find(ego, Trajectory.empty(), 10.0 + speed * INTERVAL * POINTS)
            poses = [pose_at(path.points, path.size, speed * INTERVAL * (index + 1)) for index in range(POINTS)]
        else:
            self.assumption = Assumption.PRESENT_TURN
            poses = []
            x, y, yaw = ego.x, ego.y, ego.yaw
            for _ in range(POINTS):
                middle = yaw + 0.5 * ego.yaw_rate * INTERVAL
                x += speed * INTERVAL * math.cos(middle)
                y += speed * INTERVAL * math.sin(middle)
                yaw = wrap_angle(yaw + ego.yaw_rate * INTERVAL)
                poses.append((x, y, yaw))
        table = np.array(poses, dtype=np.float64)
        x_s, y_s, yaws = (np.ascontiguousarray(table[:, index]) for index in range(3))
        return Trajectory(INTERVAL, x_s, y_s, yaws, np.full(POINTS, speed), "assumed")

    def _is_on_route(self, ego: EgoState) -> bool:
        if self._route is None or self._tracker is None:
            return False
        nearest = self._tracker.observe(ego.x, ego.y)
        position, offset = self._tracker.places[nearest]
        _, _, heading = self._route.stages[nearest].pose(position)
        return abs(offset) <= ON_ROUTE and abs(wrap_angle(ego.yaw - heading)) <= ALONG


def open_route(ego_length: float, ego_width: float) -> Route:
    """A route for an ego whose route nobody knows: it says how large the ego is, and lies where the ego never is.

    Methods look at a route only near the ego; with this one, the planned or assumed trajectory alone decides.

    Args:
        ego_length: [m].
        ego_width: [m].
    """
    x = np.array([NOWHERE, NOWHERE + 10.0])
    stage = Stage(x, np.full(2, NOWHERE), np.full(2, math.inf))
    return Route("", ego_length, ego_width, math.inf, math.inf, (stage,), (), ())


def is_open(route: Route) -> bool:
    """Whether a route is one that says nothing of the way."""
    return float(route.stages[0].x[0]) == NOWHERE if route.stages else True
