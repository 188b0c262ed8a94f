"""What is drawn of a tick: all that it has, and what it lacks or nobody can use as absent."""

import math
from dataclasses import replace

import numpy as np
import pytest

from roadmend.core.command import Trajectory
from roadmend.core.scene import EgoState, ObjectList, Scene
from roadmend.recording import topics
from roadmend.recording.codec import encode
from roadmend.recording.drawing import draw_tick
from roadmend.recording.messages import header_of

EGO = EgoState.from_yaw(3.0, 4.0, 0.7, 8.0, 0.0, 4.8, 1.8)
SCENE = Scene(12.35, EGO, ObjectList.empty(), np.empty(0, dtype=np.uint8))
PLAN = Trajectory(0.5, np.array([4.0, 8.0]), np.zeros(2), np.zeros(2), np.full(2, 8.0))


def drawn(plan: Trajectory) -> dict[str, bytes]:
    """The bytes of each topic."""
    pictures = draw_tick(SCENE, plan, None, None, header_of(SCENE.time))
    return {topic: encode(message) for topic, message in pictures}


@pytest.mark.parametrize(
    "fault",
    [
        {"yaw": np.empty(0)},
        {"y": np.zeros(1)},
        {"x": np.zeros(3)},
        {"speed": np.empty(0)},
        {"interval": math.nan},
        {"interval": math.inf},
        {"interval": 1e10},
        {"x": np.array([4.0, math.nan])},
    ],
    ids=str,
)
def test_a_plan_that_the_guard_does_not_use_is_drawn_as_absent(fault: dict[str, object]) -> None:
    none = drawn(Trajectory.empty())
    assert drawn(replace(PLAN, **fault)) == none
    assert {topic for topic, data in drawn(PLAN).items() if data != none[topic]} == {topics.PLAN, topics.MARKERS_PLAN}
