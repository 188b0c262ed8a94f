"""Topic names and quality of service, named in this one place."""

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

from roadmend.recording.qos import INFINITE_NS, Qos

CLOCK = "/clock"
EGO = "ego"
OBJECTS = "objects"
ROUTE = "route"
MAP = "map"
EVENTS = "events"
POLICY_COMMAND = "policy/command"
POLICY_TRAJECTORY = "policy/trajectory"
REPAIR_COMMAND = "repair/command"
REPAIR_STATE = "repair/state"
DIAGNOSTICS = "/diagnostics"
PARAMETER_EVENTS = "/parameter_events"

COMMAND_DEADLINE_S = 0.5  # longest silence on the command path before DDS reports a missed deadline


def _reliable(depth: int, *, latched: bool = False, deadline: Duration | None = None) -> QoSProfile:
    profile = QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=depth,
        reliability=ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )
    if deadline is not None:
        profile.deadline = deadline
    return profile


STREAM = _reliable(50)  # one message a tick: ego, objects, trajectory, repair state, clock
COMMAND = _reliable(1, deadline=Duration(seconds=COMMAND_DEADLINE_S))
LATCHED = _reliable(1, latched=True)  # route, map
EVENT = _reliable(100, latched=True)  # scenario events, complete for late joiners
DIAGNOSTIC = _reliable(10)
PARAMETER_EVENT = qos_profile_parameter_events  # as every ROS node publishes them


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
