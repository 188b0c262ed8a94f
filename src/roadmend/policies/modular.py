"""The modular driving policy: localisation, prediction, behaviour, planner and controller in one compiled step."""

import math

import numpy as np
from numpy.typing import NDArray

from roadmend.core.command import Command, Decision, Trajectory
from roadmend.core.jit import compiled, unnamed
from roadmend.core.route import Route
from roadmend.core.scene import EgoState, Objects, Scene
from roadmend.core.tick import INTERVAL
from roadmend.policies import behaviour, controller, planner, prediction
from roadmend.policies.parameters import ModularParameters
from roadmend.policies.road import RouteTables
from roadmend.policies.situation import Driver, pack

Floats = NDArray[np.float64]
Record = NDArray[np.void]

_INTERVAL_MAX = 0.5  # [s] a longer pause is a new beginning
_STOP = Decision(Command(0.0, 0.6), Trajectory.empty())  # where the ego's own state is unusable

# What is carried from tick to tick. Only `waited`, `stood`, `stopped_at` and the filters cannot be seen in a scene.
_MEMORY: dict[str, float] = {
    "stage": -1.0,
    "s": 0.0,
    "offset": 0.0,
    "s_next": math.nan,
    "offset_next": math.inf,  # localisation
    "changing": 0.0,
    "progress": 0.0,
    "change_length": 0.0,
    "change_begin": 0.0,
    "changed_at": -math.inf,
    "waited": 0.0,
    "stood": 0.0,
    "stopped_at": -1.0,  # behaviour
    "wanted": 0.0,
    "evading": 0.0,  # planner
    "correction": 0.0,
    "expected": -1.0,
    "last_wanted": 0.0,  # controller
    "known_count": 0.0,  # prediction
}


def new_driver(parameters: ModularParameters) -> Driver:
    """What a policy with these parameters begins an episode with."""
    return Driver(parameters.packed(), pack(_MEMORY), prediction.nobody_known())


@compiled
def _drive(
    route: RouteTables,
    driver: Driver,
    ego: EgoState,
    objects: Objects,
    signals: NDArray[np.uint8],
    time: float,
    intervals: tuple[float, float],
    trajectory: Floats,
) -> tuple[float, float, bool, int]:
    """A new plan; ``intervals`` [s] have passed since the last one and since the last tick.

    Returns throttle, brake, whether to change lane and the word's index.
    """
    interval, tick = intervals
    driver, ego = Driver(*driver), EgoState(*ego)
    asked, change, word = planner.deliberate(route, driver, ego, objects, signals, time, interval, trajectory)
    wanted = planner.smooth(driver.parameters, driver.memory, asked, ego.speed, interval)
    throttle, brake = controller.control(driver.parameters, driver.memory, wanted, ego.speed, tick)
    return throttle, brake, change, word


@compiled
def _hold(parameters: Record, memory: Record, speed: float, tick: float) -> tuple[float, float]:
    """Throttle and brake at a tick between two plans."""
    return controller.control(parameters, memory, memory[0].wanted, speed, tick)


class ModularPolicy:
    """A module-based driving system with perfect perception, in the manner of Pylot, Apollo and Autoware.

    It knows its route and the lanes on it, the vehicle's data sheet, and what can be seen; not the lanes, routes or
    intentions of others, and not the friction of the road.
    """

    name = "modular"

    def __init__(self, parameters: ModularParameters | None = None) -> None:
        self.parameters = parameters if parameters is not None else ModularParameters()
        self._driver = new_driver(self.parameters)
        self._road: RouteTables | None = None
        self._time = math.nan
        self._planned_at = math.nan
        self._trajectory = Trajectory.empty()

    def reset(self, route: Route) -> None:
        """Begin an episode on ``route``; all memory of earlier ones is dropped."""
        self._road = RouteTables.of(route, self.parameters)
        self._forget()

    def _forget(self) -> None:
        self._driver.memory[0] = tuple(_MEMORY.values())
        self._time = self._planned_at = math.nan

    def step(self, scene: Scene) -> Decision:
        """Decide for one tick; brakes where the ego's own state is unusable or no route has come yet."""
        ego, road = scene.ego, self._road
        if road is None or not math.isfinite(scene.time + ego.x + ego.y + ego.yaw + ego.speed + ego.length + ego.width):
            return _STOP
        interval = scene.time - self._time
        if not 0.0 < interval <= _INTERVAL_MAX:
            if interval < 0.0 or interval > _INTERVAL_MAX:
                self._forget()
            interval = INTERVAL  # assumed at the first tick
        self._time = scene.time
        since = scene.time - self._planned_at
        if since < self.parameters.planning_interval - 1e-6:
            throttle, brake = _hold(self._driver.parameters, self._driver.memory, ego.speed, interval)
            return Decision(Command(throttle, brake), self._trajectory)
        self._planned_at = scene.time
        points = np.empty((4, prediction.FINE))
        throttle, brake, change, word = _drive(
            unnamed(road),
            unnamed(self._driver),
            unnamed(ego),
            scene.objects.table,
            scene.signals,
            scene.time,
            (interval if math.isnan(since) else since, interval),
            points,
        )
        self._trajectory = Trajectory(
            prediction.FINE_INTERVAL, points[0], points[1], points[2], points[3], behaviour.WORDS[word]
        )
        return Decision(Command(throttle, brake, change), self._trajectory)
