"""Who sends the policy's commands: whether there is one who can be heard, and whether he is alone."""

from dataclasses import dataclass, field

from rclpy.node import Node

from roadmend.nodes.inputs import COMMAND, REPAIRED, TRAJECTORY, Input
from roadmend.repair.assumed_motion import Assumption

PERIOD_S = 0.2  # [s] of wall time between two looks at the graph
SETTLE_S = 1.0  # [s] in which DDS tells the rest of a node that it has begun to tell of
_NOBODY = "nobody publishes it yet"
NO_TRAJECTORY = str(Assumption.ALONG_ROUTE)


@dataclass(slots=True)
class PolicyWatch:
    """Looks at the graph when it is asked to, every PERIOD_S or so, and keeps what it saw.

    Attributes:
        node: who looks.
        is_external: whether the policy is a node of somebody else's, which an episode has to wait for.
    """

    node: Node
    is_external: bool
    missing: list[str] = field(default_factory=list)  # what must be mended before an episode can begin, for people
    warnings: list[str] = field(default_factory=list)  # all that were ever seen, for people
    has_trajectory: bool = False
    _publishers: list[str] = field(default_factory=list)  # of the policy's commands, when looked at last
    _since: dict[str, float] = field(default_factory=dict)  # wall time [s] at which a thing that lasts was seen first

    def __post_init__(self) -> None:
        if self.is_external:
            self.missing = [_NOBODY]

    def look(self, now: float) -> bool:
        """Look, at wall time ``now`` [s]; whether something has changed."""
        before = (self.missing, len(self.warnings), self.has_trajectory)
        self.missing = self._missing(now)
        self.has_trajectory = bool(TRAJECTORY.publishers(self.node)) and not TRAJECTORY.faults(self.node)
        present = [*self._crowds(COMMAND, is_counted=self.is_external), *self._crowds(REPAIRED, is_counted=False)]
        present += [f"{TRAJECTORY.topic}: {fault}" for fault in TRAJECTORY.faults(self.node)]
        for warning in self._settled(present, now):
            if warning not in self.warnings:
                self.warnings.append(warning)
        return before != (self.missing, len(self.warnings), self.has_trajectory)

    def _missing(self, now: float) -> list[str]:
        if not self.is_external:
            return []
        publishers, faults = COMMAND.publishers(self.node), COMMAND.faults(self.node)
        if publishers != self._publishers or faults:  # who takes the place of another has to settle anew
            self._publishers = publishers
            self._since.pop(COMMAND.topic, None)
        if not publishers:
            return [_NOBODY]
        if faults:
            return faults
        if len(publishers) > 1:
            return [_crowd(publishers)]
        self._since.setdefault(COMMAND.topic, now)
        return []

    def is_settled(self, now: float) -> bool:
        """Whether a policy that can be heard has been there for long enough to have told of all its topics."""
        return not self.is_external or now - self._since.get(COMMAND.topic, now) >= SETTLE_S

    def _crowds(self, wanted: Input, *, is_counted: bool) -> list[str]:
        """Several publishers where there should be one; those of one name are told apart only if ``is_counted``."""
        publishers = wanted.publishers(self.node)
        if not is_counted:  # a node of ours that was killed is seen for a while beside the one that took its place
            publishers = [*dict.fromkeys(publishers)]
        return [f"{wanted.topic}: {_crowd(publishers)}"] if len(publishers) > 1 else []

    def _settled(self, present: list[str], now: float) -> list[str]:
        """Of what is seen, what has been for a while: a node of somebody else's that leaves is seen a little longer."""
        if not self.is_external:
            return present
        for name in [name for name in self._since if name not in present and name != COMMAND.topic]:
            del self._since[name]
        return [name for name in present if now - self._since.setdefault(name, now) >= SETTLE_S]


def _crowd(publishers: list[str]) -> str:
    return f"has {len(publishers)} publishers, {' and '.join(publishers)}; end all but one"
