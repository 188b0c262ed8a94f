"""A policy and a repair method of one's own.

From the folder src/examples:

    ../../roadmend run --scenario ../../config/scenarios/demo-exit.yaml --policy careful:Careful --repair careful:LateBrake
"""

import math

from pydantic import Field

from roadmend.core.command import Command, Decision, Trajectory
from roadmend.core.parameters import Parameters
from roadmend.core.repair import Proposal
from roadmend.core.route import Route
from roadmend.core.scene import Scene

PACE = 12.0  # [m/s]


class Careful:
    """Drives at an even pace, whoever is ahead; it plans nothing, so its trajectory is empty."""

    name = "careful"

    def reset(self, route: Route) -> None:
        """Nothing is remembered."""

    def step(self, scene: Scene) -> Decision:
        """Push below the pace, brake above it; change lanes as soon as the route wants it."""
        action = min(max(0.5 * (PACE - scene.ego.speed), -1.0), 1.0)
        return Decision(Command.from_action(action, change_lane=True), Trajectory.empty())


class LateBrakeParameters(Parameters):
    """What can be set: ``--ros-args -p LateBrake.distance:=12.0``, or ``bag resimulate --set distance=12.0``."""

    distance: float = Field(8.0, ge=0.0, le=50.0, description="brakes where anybody ahead is as near as this [m]")


class LateBrake:
    """Brakes hard where anybody's centre is near ahead."""

    name = "late brake"

    def __init__(self, parameters: LateBrakeParameters) -> None:
        self._distance = parameters.distance

    def reset(self, route: Route) -> None:
        """Nothing is remembered."""

    def propose(self, scene: Scene, decision: Decision) -> Proposal:
        """Score: by how much the nearest is too near [m]; above 0 it steps in."""
        del decision  # the merger holds it against the proposal: of the two the one that brakes more is driven
        others, ego = scene.objects, scene.ego
        x, y = others.x - ego.x, others.y - ego.y
        is_ahead = x * math.cos(ego.yaw) + y * math.sin(ego.yaw) > 0.0
        nearest = min((x[is_ahead] ** 2 + y[is_ahead] ** 2) ** 0.5, default=1000.0)
        return Proposal(self._distance - nearest, 0.0, -0.8, reason=f"the nearest is {nearest:.1f} m away")
