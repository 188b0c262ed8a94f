"""Everything that is drawn of one tick, by topic: for the running graph and for bags that no graph drove."""

import math
from collections.abc import Iterator
from typing import Any

from nav_msgs.msg import Path
from roadmend_msgs import msg
from std_msgs.msg import Float64, Header
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import MarkerArray

from roadmend.core.command import Trajectory
from roadmend.core.geometry import nearest_distance
from roadmend.core.route import Route
from roadmend.core.scene import Scene
from roadmend.nodes.markers import ego_markers, object_markers, path_of, plan_markers, signal_markers, transform_of

MARKERS_OBJECTS = "markers/objects"
MARKERS_EGO = "markers/ego"
MARKERS_PLAN = "markers/plan"
MARKERS_MAP = "markers/map"
PLAN = "plan"
DISTANCE = "ego/distance"
TF = "/tf"

DRAWINGS = {  # what is drawn at every tick
    TF: TFMessage,
    MARKERS_OBJECTS: MarkerArray,
    MARKERS_EGO: MarkerArray,
    MARKERS_PLAN: MarkerArray,
    PLAN: Path,
    DISTANCE: Float64,
}


def draw_tick(
    scene: Scene,
    plan: Trajectory,
    state: msg.RepairState | None,
    route: Route | None,
    header: Header,
    text_radius: float = 40.0,
) -> Iterator[tuple[str, Any]]:
    """Topics and messages that show one tick; what it lacks is drawn as absent.

    Args:
        scene: what there was to see.
        plan: what the policy intended; without points if nothing.
        state: what the repair node said.
        route: for the traffic lights on it.
        header: stamp of the tick, frame map.
        text_radius: how near to the ego an object carries its id and speed [m].
    """
    triggers = frozenset() if state is None else frozenset(state.trigger_id)
    things = object_markers(scene.objects, scene.ego, header, triggers=triggers, text_radius=text_radius)
    if route is not None:
        things.markers.extend(signal_markers(route, scene.signals, header))
    yield TF, TFMessage(transforms=[transform_of(scene.ego, header)])
    yield MARKERS_OBJECTS, things
    yield MARKERS_EGO, ego_markers(scene.ego, state, header)
    yield MARKERS_PLAN, plan_markers(plan, scene.ego, header)
    yield PLAN, path_of(plan, header)
    distance = nearest_distance(scene.ego, scene.objects)
    if math.isfinite(distance):
        yield DISTANCE, Float64(data=distance)
