"""The neural policy's eyes: keeps what is carried from scene to scene and turns each scene into tokens."""

import math

import numpy as np
from numpy.typing import NDArray

from roadmend.core.command import Trajectory
from roadmend.core.jit import compiled, unnamed
from roadmend.core.route import Route
from roadmend.core.scene import Scene
from roadmend.core.tick import INTERVAL
from roadmend.policies import neural_tokens, prediction
from roadmend.policies.parameters import ModularParameters
from roadmend.policies.path_ahead import PathAhead, pose_ahead, speed_on
from roadmend.policies.road import RouteTables

Floats = NDArray[np.float64]
Record = NDArray[np.void]

_INTERVAL_MAX = 0.5  # [s] a longer pause is a new beginning
_HELD = 2.0  # [s] that the commanded acceleration is taken to last


@compiled
def _roll_forward(path: PathAhead, parameters: Record, action: float, speed: float, out: Floats) -> None:
    """Where a held action leads along the path: x, y, yaw and speed, the rows of ``out`` (4, FINE)."""
    path, p = PathAhead(*path), parameters[0]
    force = (
        min(p.engine_acceleration, p.engine_power / max(speed, 1.0)) * action if action > 0.0 else p.full_brake * action
    )
    acceleration = force - p.drag * speed * speed - p.rolling
    ahead, v = 0.0, speed
    step = prediction.FINE_INTERVAL
    for index in range(prediction.FINE):
        after = v
        if index * step < _HELD:
            after = max(0.0, v + acceleration * step)
            if acceleration > 0.0:
                after = max(v, min(after, speed_on(path, ahead)))
        ahead += 0.5 * (v + after) * step
        v = after
        out[0, index], out[1, index], out[2, index] = pose_ahead(path, ahead)
        out[3, index] = v


class Observer:
    """Turns the scenes of an episode into tokens, one after another."""

    def __init__(self) -> None:
        self._parameters = ModularParameters()
        self._road: RouteTables | None = None
        self._driver = neural_tokens.new_driver(self._parameters)
        self._time = math.nan
        self._path = PathAhead(np.empty((0, 7)), 1.0)
        self._speed = 0.0
        self._tokens = np.zeros((neural_tokens.TOKENS, neural_tokens.COLUMNS), dtype=np.float32)
        self.objects = np.full(neural_tokens.TOKENS, -1, dtype=np.int64)  # row in the scene of each token's object

    def reset(self, route: Route) -> None:
        """Begin an episode on ``route``; all memory of earlier ones is dropped."""
        self._road = RouteTables.of(route, self._parameters)
        self._driver = neural_tokens.new_driver(self._parameters)
        self._time = math.nan

    def observe(self, scene: Scene) -> NDArray[np.float32] | None:
        """The tokens of a scene, shape (N, COLUMNS), valid until the next call.

        None where the ego's own state is not finite or no route has come yet.
        """
        ego, road = scene.ego, self._road
        if road is None or not math.isfinite(scene.time + ego.x + ego.y + ego.yaw + ego.speed + ego.length + ego.width):
            return None
        interval = scene.time - self._time
        if not 0.0 < interval <= _INTERVAL_MAX:
            if interval < 0.0 or interval > _INTERVAL_MAX:
                self._driver = neural_tokens.new_driver(self._parameters)
            interval = INTERVAL  # assumed at the first tick
        self._time = scene.time
        self._speed = ego.speed
        count, points, spacing = neural_tokens.tokenise(
            unnamed(road),
            unnamed(self._driver),
            unnamed(ego),
            scene.objects.table,
            scene.signals,
            (scene.time, interval),
            self._tokens,
            self.objects,
        )
        self._path = PathAhead(points, spacing)
        return self._tokens[:count]

    @property
    def may_change(self) -> bool:
        """Whether the ego was inside the window of its next lane change, and not changing, at the last scene."""
        return neural_tokens.may_change(self._tokens)

    def begin_change(self) -> None:
        """Say that the ego has been told to change lane at the last scene."""
        m = self._driver.memory[0]
        m["changing"], m["progress"], m["change_length"], m["change_begin"] = 1.0, 0.0, 0.0, m["s"]

    def trajectory(self, action: float, word: str) -> Trajectory:
        """The plan that an action at the last scene amounts to.

        The action's acceleration lasts for 2 s, or until the speed allowed on the path is reached, and the speed stays
        from then on; the ego keeps to its path, lane change included.
        """
        points = np.empty((4, prediction.FINE))
        _roll_forward(unnamed(self._path), self._driver.parameters, action, self._speed, points)
        return Trajectory(prediction.FINE_INTERVAL, points[0], points[1], points[2], points[3], word)
