import math

import numpy as np
import pytest

from roadmend.core.outcome import Event, EventKind
from roadmend.core.scene import EgoState, ObjectKind, ObjectList, Scene
from roadmend.training.collision import describe_collision


def scene_with(x, y, yaw, speed=3.0):
    objects = ObjectList.of(
        id=[7],
        kind=ObjectKind.CAR,
        x=x,
        y=y,
        yaw=yaw,
        speed=speed,
        acceleration=0.0,
        yaw_rate=0.0,
        length=4.0,
        width=2.0,
    )
    ego = EgoState.from_yaw(100.0, 50.0, 0.5 * math.pi, 8.0, 0.0, 4.0, 2.0)  # heads north
    return Scene(1.0, ego, objects, np.zeros(0, dtype=np.uint8))


HIT = Event(1.05, EventKind.COLLISION, "bang", (7,), ("v3",))
NORTH, EAST, SOUTH = 0.5 * math.pi, 0.0, -0.5 * math.pi


@pytest.mark.parametrize(
    ("x", "y", "yaw", "manner"),
    [
        (100.3, 54.1, NORTH, "ran into"),
        (100.0, 45.9, NORTH, "hit from behind"),
        (100.0, 54.1, SOUTH, "head on"),
        (101.0, 53.1, EAST, "struck flank"),
        (96.9, 50.5, EAST, "hit in the side"),
        (102.1, 50.5, NORTH, "sideswipe"),
    ],
)
def test_the_parts_that_met_name_the_collision(x, y, yaw, manner):
    collision = describe_collision(scene_with(x, y, yaw), HIT)
    assert collision.manner == manner
    assert (collision.other, collision.name, collision.ego_speed) == ("car", "v3", 8.0)
    assert collision.text.startswith(f"{manner}: ego at 8.0 m/s, car v3 at 3.0 m/s")


def test_without_a_collision_or_a_sight_of_the_other_there_is_nothing_to_say():
    scene = scene_with(100.0, 54.1, NORTH)
    assert describe_collision(scene, Event(1.0, EventKind.GOAL, "there")) is None
    assert describe_collision(scene, Event(1.0, EventKind.COLLISION, "bang", (8,), ("v4",))) is None


def test_whom_nobody_named_has_no_name():
    seen = describe_collision(scene_with(102.1, 50.5, NORTH), Event(1.0, EventKind.COLLISION, "", HIT.object_ids, ()))
    assert (seen.other, seen.name) == ("car", "")
