"""A driving policy of one's own, as a class: it keeps a pace, and a gap to whoever is ahead in its lane.

From the folder src/examples:

    ../../roadmend run --scenario ../../config/scenarios/demo-exit.yaml --policy cruise:Cruise
"""

import cmath

from roadmend import Command, Decision, Route, Scene, Trajectory


class Cruise:
    """Wants 12 m/s, and less behind others; changes lanes as soon as the route wants it; plans no trajectory."""

    name = "cruise"

    def reset(self, route: Route) -> None:
        """Nothing is remembered from one tick to the next."""

    def step(self, scene: Scene) -> Decision:
        """Decide for one tick, of 0.05 s."""
        # Where the others' centres are, as seen from the ego: ahead + 1j * to the left [m]
        place = (scene.objects.x - scene.ego.x + 1j * (scene.objects.y - scene.ego.y)) * cmath.rect(1.0, -scene.ego.yaw)
        gap = place.real[(place.real > 0.0) & (abs(place.imag) < 2.0)].min(initial=100.0)
        action = 0.5 * (min(12.0, max(0.0, gap - 8.0) / 1.5) - scene.ego.speed)  # throttle - brake
        return Decision(Command.from_action(min(max(action, -1.0), 1.0), change_lane=True), Trajectory.empty())
