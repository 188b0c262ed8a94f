"""The graph's topics: names, types, and what their publishers offer. Named in this one place."""

from collections.abc import Iterable

from roadmend.recording.qos import Qos

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
MARKERS_OBJECTS = "markers/objects"
MARKERS_EGO = "markers/ego"
MARKERS_PLAN = "markers/plan"
MARKERS_MAP = "markers/map"
PLAN = "plan"
DISTANCE = "ego/distance"
TF = "/tf"
DIAGNOSTICS = "/diagnostics"
CONFIGURATION = "configuration"
PARAMETER_EVENTS = "/parameter_events"
RECORDER_PROGRESS = "recorder/_progress"

COMMAND_DEADLINE_NS = 500_000_000  # longest silence on the command path before DDS reports a missed deadline

STREAM = Qos(depth=50)  # one message a tick: ego, objects, trajectory, repair state, clock
COMMAND = Qos(depth=1, deadline_ns=COMMAND_DEADLINE_NS)
LATCHED = Qos(depth=1, durability="transient_local")  # route, map, each node's configuration
EVENT = Qos(depth=100, durability="transient_local")  # scenario events, complete for late joiners
DIAGNOSTIC = Qos(depth=10)

OFFERS = {  # that differ from STREAM
    ROUTE: LATCHED,
    MAP: LATCHED,
    MARKERS_MAP: LATCHED,
    EVENTS: EVENT,
    POLICY_COMMAND: COMMAND,
    REPAIR_COMMAND: COMMAND,
    DIAGNOSTICS: DIAGNOSTIC,
    CONFIGURATION: LATCHED,
    RECORDER_PROGRESS: DIAGNOSTIC,
}

TYPES = {  # of what a recorded episode is read from
    EGO: "nav_msgs/msg/Odometry",
    OBJECTS: "roadmend_msgs/msg/ObjectList",
    ROUTE: "roadmend_msgs/msg/Route",
    MAP: "roadmend_msgs/msg/Map",
    EVENTS: "roadmend_msgs/msg/ScenarioEvent",
    POLICY_COMMAND: "roadmend_msgs/msg/Command",
    POLICY_TRAJECTORY: "roadmend_msgs/msg/Trajectory",
    REPAIR_COMMAND: "roadmend_msgs/msg/Command",
    REPAIR_STATE: "roadmend_msgs/msg/RepairState",
}


SHADOW = "shadow"  # namespace, below a graph's own, of what another method would have done


def own(names: Iterable[str]) -> str | None:
    """Of the topics of one kind in a bag, or of the namespaces with "/" at their end, the graph's own: the shortest.

    A shadow's is none, even where it is the only one: nobody drove on it. None where there is no other.
    """
    return min((name for name in names if f"/{SHADOW}/" not in name), key=len, default=None)
