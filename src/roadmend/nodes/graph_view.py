"""What the simulator sees of the graph it runs in: who joined, what they announced, what is waited for.

All of it goes into a file beside the summary whenever it changes, so that the launcher, which is no node, can tell.
"""

import contextlib
import json
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node

from roadmend.core.errors import InputError
from roadmend.core.whole_file import write_text
from roadmend.nodes import qos
from roadmend.nodes.announcement import EXTERNAL
from roadmend.nodes.configuration import Announcements
from roadmend.nodes.inputs import COMMAND
from roadmend.nodes.policy_watch import NO_TRAJECTORY, PERIOD_S, PolicyWatch
from roadmend.recording import topics

SUFFIX = ".graph"  # of the file
DRIVING_PERIOD_S = 1.0  # [s] of wall time between two looks while a policy drives
UNWATCHED = "unwatched"


class GraphView:
    """Kept by sim_node, which looks regularly."""

    def __init__(self, node: Node, driver: str, summary: str) -> None:
        """Begin to listen.

        Args:
            node: the simulator.
            driver: who sends the policy's commands: unwatched, own or external.
            summary: path of the simulator's summary; without one nothing is written.
        """
        self.repair_health = "repair_node says nothing"
        self._node = node
        self._watch = PolicyWatch(node, is_external=driver == EXTERNAL)
        self._is_watching = driver != UNWATCHED
        self._announcements = Announcements(node, self._on_heard)
        self._file = Path(summary).with_suffix(SUFFIX) if summary else None
        self._is_due = True
        self._looked_at = 0.0  # wall time [s]
        self._is_settled = False
        self._waiting: list[str] = []
        node.create_subscription(DiagnosticArray, topics.DIAGNOSTICS, self._on_health, qos.DIAGNOSTIC)

    @property
    def is_external(self) -> bool:
        """Whether the policy is a node of somebody else's."""
        return self._watch.is_external

    @property
    def missing(self) -> list[str]:
        """What must come before an episode can begin, of a policy in a node of its own; one line for people, or none."""
        if not self._watch.missing:
            return []
        domain = f"ROS_DOMAIN_ID={self._node.context.get_domain_id()}"
        return [f"a policy: {COMMAND.describe(self._node)} in {domain}; missing: {'; '.join(self._watch.missing)}"]

    @property
    def does_without_trajectory(self) -> bool:
        """Whether nobody publishes the policy's plans and nobody need."""
        return self.is_external and not self._watch.missing and not self._watch.has_trajectory

    def is_settled(self, now: float) -> bool:
        """Whether, at wall time ``now`` [s], all of a policy in a node of its own has been seen."""
        return self._watch.is_settled(now)

    def original_name(self, name: str) -> str:
        """The name that a node of ours has when nobody renames it."""
        for one in self._announcements.by_node.values():
            if one.is_ours and one.node.rpartition("/")[2] == name:
                return f"{one.role}_node"
        return name

    def look(self, now: float, waiting_for: Callable[[float], list[str]], *, is_driving: bool) -> None:
        """Look around if it is time to.

        Args:
            now: wall time [s].
            waiting_for: tells, given ``now``, what else keeps the drive from beginning, for people.
            is_driving: whether it has begun.
        """
        if now - self._looked_at < (DRIVING_PERIOD_S if is_driving else PERIOD_S):
            return
        self._looked_at = now
        self._announcements.look(is_driving=is_driving)
        changed = self._is_watching and self._watch.look(now)
        is_settled = self._watch.is_settled(now)
        changed |= is_settled != self._is_settled
        self._is_settled = is_settled
        waiting = [*waiting_for(now), *self.missing]
        if self._file is not None and (changed or self._is_due or waiting != self._waiting):
            self._waiting, self._is_due = waiting, False
            with contextlib.suppress(InputError):  # a full disk: the summary will tell
                write_text(self._file, json.dumps({"waiting": waiting, **self.content()}))

    def content(self) -> dict[str, Any]:
        """As plain values: ``account`` (see ``announcement.account``), ``announced`` by node, ``warnings``, ``notes``."""
        account = self._announcements.account
        notes = [one.values["fitting"] for one in self._announcements.by_node.values() if "fitting" in one.values]
        if self.does_without_trajectory and self._is_settled:
            notes.append(NO_TRAJECTORY)
        return {
            "account": account,
            "announced": {name: asdict(one) for name, one in self._announcements.by_node.items()},
            "warnings": [*self._watch.warnings],
            "notes": notes,
        }

    def _on_heard(self) -> None:
        self._is_due = True

    def _on_health(self, message: Any) -> None:
        for status in message.status:
            if self.original_name(status.name.rpartition("/")[2]) == "repair_node":
                self.repair_health = status.message
