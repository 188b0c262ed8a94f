"""What a driving policy and a repairer must offer; the rooms that run them know no more than this."""

from typing import Protocol

from roadmend.core.command import Decision
from roadmend.core.repair import Repair
from roadmend.core.route import Route
from roadmend.core.scene import Scene


class Policy(Protocol):
    """A driving policy. Deterministic: the same scenes after the same reset give the same decisions."""

    name: str

    def reset(self, route: Route) -> None:
        """Begin an episode on ``route``; all memory of earlier ones is dropped."""

    def step(self, scene: Scene) -> Decision:
        """Decide for one tick."""


class Repairer(Protocol):
    """Stands between the policy and the vehicle. Never raises: whatever goes wrong, it answers with a command."""

    name: str

    def reset(self, route: Route) -> None:
        """Begin an episode on ``route``; all memory of earlier ones is dropped."""

    def step(self, scene: Scene, decision: Decision) -> Repair:
        """Check one decision and repair it where needed."""
