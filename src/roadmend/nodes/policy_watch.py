"""Who sends the policy's commands: whether there is one who can be heard, and whether he is alone."""

from dataclasses import dataclass, field

from rclpy.node import Node

from roadmend.nodes.inputs import COMMAND, REPAIRED, TRAJECTORY, Input

PERIOD_S = 0.2  # [s] of wall time between two looks at the graph
SETTLE_S = 1.0  # [s] in which DDS tells the rest of a node that it has begun to tell of
ANYBODY = "any"
NO_TRAJECTORY = "no planned trajectory: the repair assumes the ego's present motion along the route"


@dataclass(slots=True)
class PolicyWatch:
    """Looks at the graph when it is asked to, every PERIOD_S or so, and keeps what it saw.

    Attributes:
        node: who looks.
        policy: name of the only node that may send the policy's commands; ANYBODY: one node, whoever it is; empty: it
            is not looked at.
        repair: the same for the repaired commands.
    """

    node: Node
    policy: str
    repair: str = "repair_node"
    missing: list[str] = field(default_factory=list)  # what must be mended before an episode can begin, for people
    warnings: list[str] = field(default_factory=list)  # all that were ever seen, for people
    has_trajectory: bool = False
    _since: dict[str, float] = field(
        default_factory=dict
    )  # wall time [s] at which a thing was seen first, while it lasts

    def look(self, now: float) -> bool:
        """Look, at wall time ``now`` [s]; whether something has changed."""
        if not self.policy:
            return False
        before = (self.missing, len(self.warnings), self.has_trajectory)
        self.missing = self._missing(now)
        self.has_trajectory = bool(TRAJECTORY.publishers(self.node)) and not TRAJECTORY.faults(self.node)
        present = [*self._crowds(COMMAND, self.policy), *self._crowds(REPAIRED, self.repair)]
        present += [f"{TRAJECTORY.topic}: {fault}" for fault in TRAJECTORY.faults(self.node)]
        for warning in self._settled(present, now):
            if warning not in self.warnings:
                self.warnings.append(warning)
        return before != (self.missing, len(self.warnings), self.has_trajectory)

    def _missing(self, now: float) -> list[str]:
        if self.policy != ANYBODY:
            return []
        publishers, faults = COMMAND.publishers(self.node), COMMAND.faults(self.node)
        if not publishers:
            self._since.pop(COMMAND.topic, None)
            return ["nobody publishes it yet"]
        if faults:
            self._since.pop(COMMAND.topic, None)
            return faults
        if len(publishers) > 1:
            return [_crowd(publishers)]
        self._since.setdefault(COMMAND.topic, now)
        return []

    def is_settled(self, now: float) -> bool:
        """Whether a policy that can be heard has been there for long enough to have told of all its topics."""
        return self.policy != ANYBODY or now - self._since.get(COMMAND.topic, now) >= SETTLE_S

    def _crowds(self, wanted: Input, owner: str) -> list[str]:
        """The publishers that there are besides the one who may."""
        publishers = wanted.publishers(self.node)
        if owner != ANYBODY:  # one that was killed is seen for a while beside the one that took its place
            publishers = [*dict.fromkeys(publishers)]
        return [f"{wanted.topic}: {_crowd(publishers)}"] if len(publishers) > 1 else []

    def _settled(self, present: list[str], now: float) -> list[str]:
        """Of what is seen, what has been for a while: a node that leaves is seen a little longer than it is there."""
        for name in [name for name in self._since if name not in present and name != COMMAND.topic]:
            del self._since[name]
        return [name for name in present if now - self._since.setdefault(name, now) >= SETTLE_S]


def _crowd(publishers: list[str]) -> str:
    return f"has {len(publishers)} publishers, {' and '.join(publishers)}; end all but one"
