"""Quality of service in ROS's terms: of the graph's topics, and of what bags record."""

from typing import Any

from rclpy.duration import Duration
from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoSProfile,
    ReliabilityPolicy,
    qos_profile_parameter_events,
)

from roadmend.recording import topics
from roadmend.recording.qos import INFINITE_NS, Qos


def profile_of(offer: Qos) -> QoSProfile:
    """A recorded offer in ROS's terms; what a recorder could not see gets ROS's default."""
    return QoSProfile(
        history=HistoryPolicy.KEEP_ALL if offer.history == "keep_all" else HistoryPolicy.KEEP_LAST,
        depth=offer.depth,
        reliability=_policy(ReliabilityPolicy, offer.reliability, ReliabilityPolicy.RELIABLE),
        durability=_policy(DurabilityPolicy, offer.durability, DurabilityPolicy.VOLATILE),
        deadline=Duration(nanoseconds=offer.deadline_ns),
        lifespan=Duration(nanoseconds=offer.lifespan_ns),
        liveliness=_policy(LivelinessPolicy, offer.liveliness, LivelinessPolicy.AUTOMATIC),
        liveliness_lease_duration=Duration(nanoseconds=offer.liveliness_lease_ns),
        avoid_ros_namespace_conventions=offer.avoid_ros_namespace_conventions,
    )


def offer_from(profile: QoSProfile) -> Qos:
    """A publisher's profile as bags record it: DDS gives away what a default of 0 means."""
    return Qos(
        profile.history.name.lower(),
        profile.depth,
        profile.reliability.name.lower(),
        profile.durability.name.lower(),
        profile.deadline.nanoseconds or INFINITE_NS,
        profile.lifespan.nanoseconds or INFINITE_NS,
        _policy(LivelinessPolicy, profile.liveliness.name.lower(), LivelinessPolicy.AUTOMATIC).name.lower(),
        profile.liveliness_lease_duration.nanoseconds or INFINITE_NS,
        profile.avoid_ros_namespace_conventions,
    )


def _policy(kind: Any, name: str, default: Any) -> Any:
    """A policy by its name in lower case."""
    found = {policy.name.lower(): policy for policy in kind}.get(name, default)
    return default if found.name in {"UNKNOWN", "SYSTEM_DEFAULT", "BEST_AVAILABLE"} else found


STREAM = profile_of(topics.STREAM)
COMMAND = profile_of(topics.COMMAND)
LATCHED = profile_of(topics.LATCHED)
EVENT = profile_of(topics.EVENT)
DIAGNOSTIC = profile_of(topics.DIAGNOSTIC)
PARAMETER_EVENT = qos_profile_parameter_events  # as every ROS node publishes them
