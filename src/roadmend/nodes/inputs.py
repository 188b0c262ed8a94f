"""A topic that somebody else is to publish: what is asked of them, and what is wrong with those who do."""

from dataclasses import dataclass
from typing import Any

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSCompatibility, QoSProfile, ReliabilityPolicy, qos_check_compatible

from roadmend.nodes import qos
from roadmend.nodes.discovery import node_of
from roadmend.recording import topics
from roadmend.recording.qos import INFINITE_NS

_NS = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class Input:
    """What is listened to."""

    topic: str
    type_name: str  # as "roadmend_msgs/msg/Command"
    request: QoSProfile

    def describe(self, node: Node) -> str:
        """For people: type, topic under the name that it has for ``node``, and quality of service."""
        return f"{self.type_name} on {node.resolve_topic_name(self.topic)} ({_words(self.request)})"

    def publishers(self, node: Node) -> list[str]:
        """Full names of the nodes that publish it, one for each publisher, whether they can be heard or not."""
        return sorted(filter(None, map(node_of, node.get_publishers_info_by_topic(self.topic))))

    def endpoints(self, node: Node) -> list[str]:
        """As ``heard``, but with an empty name for each publisher whose node DDS has not told yet."""
        infos = node.get_publishers_info_by_topic(self.topic)
        return [node_of(info) for info in infos if not self._fault(info)]

    def heard(self, node: Node) -> list[str]:
        """As ``publishers``, but only those whose messages arrive."""
        infos = node.get_publishers_info_by_topic(self.topic)
        return sorted(node_of(info) for info in infos if node_of(info) and not self._fault(info))

    def faults(self, node: Node) -> list[str]:
        """Why a publisher that is there is not heard; one line for people each, empty if there is none."""
        infos = node.get_publishers_info_by_topic(self.topic)
        return [f"{node_of(info)} {fault}" for info in infos if node_of(info) and (fault := self._fault(info))]

    def _fault(self, info: Any) -> str:
        if info.topic_type != self.type_name:
            return f"publishes {info.topic_type}; publish {self.type_name}"
        verdict, reason = qos_check_compatible(info.qos_profile, self.request)
        if verdict != QoSCompatibility.ERROR:
            return ""
        why = reason.replace("ERROR: ", "").strip().rstrip(";").replace(";", ", ")
        return f"offers an incompatible QoS ({why}); offer {_words(self.request)}"


COMMAND = Input(topics.POLICY_COMMAND, topics.TYPES[topics.POLICY_COMMAND], qos.COMMAND)
TRAJECTORY = Input(topics.POLICY_TRAJECTORY, topics.TYPES[topics.POLICY_TRAJECTORY], qos.STREAM)
REPAIRED = Input(topics.REPAIR_COMMAND, topics.TYPES[topics.REPAIR_COMMAND], qos.COMMAND)


def _words(profile: QoSProfile) -> str:
    said = [
        "reliable" if profile.reliability == ReliabilityPolicy.RELIABLE else "best effort",
        f"depth {profile.depth}",
    ]
    if profile.durability == DurabilityPolicy.TRANSIENT_LOCAL:
        said.append("transient local")
    if 0 < profile.deadline.nanoseconds < INFINITE_NS:
        said.append(f"deadline {profile.deadline.nanoseconds * _NS:g} s or less")
    return ", ".join(said)
