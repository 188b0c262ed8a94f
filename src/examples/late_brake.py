"""A repair method of one's own, with a parameter: it brakes where the ego would soon be where somebody ahead is.

From the folder src/examples:

    ../../roadmend run --scenario ../../config/scenarios/demo-exit.yaml --repair late_brake:LateBrake
"""

import cmath

from pydantic import Field

from roadmend import Decision, Parameters, Proposal, Route, Scene


class Settings(Parameters):
    """What can be set: ``-p LateBrake.time:=3.0`` in the graph, ``repair_parameters={"time": 3.0}`` in Python."""

    time: float = Field(2.0, gt=0.0, le=10.0, description="until the centres meet, below which it brakes [s]")


class LateBrake:
    """Score: 1 / time until the centres meet [1/s], were all to drive the ego's way; above the threshold it steps in."""

    name = "late brake"

    def __init__(self, parameters: Settings) -> None:
        self._threshold = 1.0 / parameters.time

    def reset(self, route: Route) -> None:
        """Nothing is remembered from one tick to the next."""

    def propose(self, scene: Scene, decision: Decision) -> Proposal:
        """Judge one tick; of the answer and the policy's decision the guard drives the one that brakes more."""
        # Where the others' centres are, as seen from the ego: ahead + 1j * to the left [m]
        place = (scene.objects.x - scene.ego.x + 1j * (scene.objects.y - scene.ego.y)) * cmath.rect(1.0, -scene.ego.yaw)
        lane = (place.real > 0.0) & (abs(place.imag) < 2.0)
        score = float(((scene.ego.speed - scene.objects.speed)[lane] / place.real[lane]).max(initial=0.0))
        return Proposal(score, self._threshold, action=-0.8, reason=f"{score:.2f}/s to a contact ahead")
