"""A moment of driving in which nothing is special: what whoever drives or repairs must be able to answer."""

from typing import NamedTuple

import numpy as np

from roadmend.core.command import Command, Decision, Trajectory
from roadmend.core.route import Route, Stage
from roadmend.core.scene import OBJECT, EgoState, ObjectList, Scene


class PlainMoment(NamedTuple):
    """A route, a scene on it, and what somebody decided there."""

    route: Route
    scene: Scene
    decision: Decision


def plain_moment() -> PlainMoment:
    """On a straight road, 10 m behind its begin, at 5 m/s and 20 m behind another."""
    x = np.array([0.0, 50.0, 100.0])
    stage = Stage(x, np.zeros(3), np.full(3, 10.0))
    objects = ObjectList(np.ones(1, dtype=OBJECT)).with_columns(x=30.0, y=0.0)
    ego = EgoState.from_yaw(10.0, 0.0, 0.0, 5.0, 0.0, 4.5, 1.8)
    return PlainMoment(
        Route("warm-up", 4.5, 1.8, 90.0, 1.0, (stage,), (), ()),
        Scene(0.0, ego, objects, np.zeros(0, dtype=np.uint8)),
        Decision(Command(0.1, 0.0), Trajectory.empty()),
    )
