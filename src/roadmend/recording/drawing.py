"""Everything that is drawn of one tick, by topic: for the running graph and for bags that no graph drove."""

import math
from collections.abc import Iterator
from typing import Any

from roadmend.core.command import Trajectory
from roadmend.core.geometry import nearest_distance
from roadmend.core.repair import Repair
from roadmend.core.route import Route
from roadmend.core.scene import Scene
from roadmend.recording.codec import MessageType
from roadmend.recording.markers import (
    ego_markers,
    object_markers,
    path_of,
    plan_markers,
    signal_markers,
    transform_of,
)
from roadmend.recording.topics import DISTANCE, MARKERS_EGO, MARKERS_OBJECTS, MARKERS_PLAN, PLAN, TF
from roadmend.repair.sanitise import usable_plan

FRAMES = MessageType("tf2_msgs/msg/TFMessage")
NUMBER = MessageType("std_msgs/msg/Float64")


def draw_tick(
    scene: Scene,
    plan: Trajectory,
    repair: Repair | None,
    route: Route | None,
    header: Any,
    text_radius: float = 40.0,
) -> Iterator[tuple[str, Any]]:
    """Topics and messages that show one tick; what it lacks is drawn as absent.

    Args:
        scene: what there was to see.
        plan: what the policy intended; without points if nothing. An unusable one, which the guard passes over as well,
            is drawn as absent.
        repair: what the repair node said.
        route: for the traffic lights on it.
        header: stamp of the tick, frame map.
        text_radius: how near to the ego an object carries its id and speed [m].
    """
    plan = usable_plan(plan)
    triggers = frozenset(() if repair is None else (trigger.object_id for trigger in repair.triggers))
    things = object_markers(scene.objects, scene.ego, header, triggers=triggers, text_radius=text_radius)
    if route is not None:
        things.markers.extend(signal_markers(route, scene.signals, header))
    yield TF, FRAMES(transforms=[transform_of(scene.ego, header)])
    yield MARKERS_OBJECTS, things
    yield MARKERS_EGO, ego_markers(scene.ego, repair, header)
    yield MARKERS_PLAN, plan_markers(plan, scene.ego, header)
    yield PLAN, path_of(plan, header)
    distance = nearest_distance(scene.ego, scene.objects)
    if math.isfinite(distance):
        yield DISTANCE, NUMBER(data=distance)
