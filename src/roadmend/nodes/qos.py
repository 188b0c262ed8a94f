"""Topic names and quality of service, named in this one place."""

from rclpy.duration import Duration
from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    QoSProfile,
    ReliabilityPolicy,
    qos_profile_parameter_events,
)

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
