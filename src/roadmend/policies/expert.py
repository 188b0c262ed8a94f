"""The privileged expert that the neural policy learns from: the modular planner with what only a simulator knows."""

import math

import numpy as np
from numpy.typing import NDArray

from roadmend.core.command import Command, Decision, Trajectory
from roadmend.core.jit import compiled, unnamed
from roadmend.core.route import Route
from roadmend.core.scene import EgoState, Objects, Scene
from roadmend.core.tick import INTERVAL
from roadmend.policies import behaviour, controller, planner, prediction
from roadmend.policies.modular import new_driver
from roadmend.policies.parameters import ModularParameters
from roadmend.policies.road import RouteTables
from roadmend.policies.situation import Driver

Floats = NDArray[np.float64]
Record = NDArray[np.void]

_INTERVAL_MAX = 0.5  # [s] a longer pause is a new beginning
_STOP = Decision(Command(0.0, 0.6), Trajectory.empty())
_GRAVITY = 9.81  # [m/s2]
CAUTION = {"headway": 1.5, "cut_in_horizon": 2.5, "trust": 2.5, "time_margin": 0.4, "front_margin": 1.0}


def expert_parameters(friction: float) -> ModularParameters:
    """The modular policy's parameters with more caution, and with braking that a road of ``friction`` can bear."""
    grip = friction * _GRAVITY  # [m/s2]
    shares = {
        "deceleration": 0.45,
        "lateral_acceleration": 0.6,
        "yellow_deceleration": 0.6,
        "red_deceleration": 0.85,
        "hold_deceleration": 0.7,
    }
    usual = ModularParameters().model_dump()
    bounds = ModularParameters.model_json_schema()["properties"]
    bearable = {name: max(min(usual[name], share * grip), bounds[name]["minimum"]) for name, share in shares.items()}
    return ModularParameters(**CAUTION, **bearable)


@compiled
def action_for(parameters: Record, wanted: float, speed: float) -> float:
    """The action in [-1, 1] that gives ``wanted`` [m/s2] at ``speed`` [m/s], by the inverse of a nominal vehicle."""
    p = parameters[0]
    if controller.is_held(wanted, speed):
        return -float(p.standstill_brake)
    return controller.action_for_force(parameters, wanted + p.drag * speed * speed + p.rolling, speed)


@compiled
def _consider(
    route: RouteTables,
    driver: Driver,
    ego: EgoState,
    objects: Objects,
    signals: NDArray[np.uint8],
    time: float,
    interval: float,
    trajectory: Floats,
) -> tuple[float, bool, int]:
    """One pass through the modules of the modular policy: the action, whether to change lane and the word's index.

    Unlike there the acceleration is neither limited in jerk nor corrected by an integral: the answer depends on the
    scene and not on what was answered before, which is what imitation needs.
    """
    driver, ego = Driver(*driver), EgoState(*ego)
    asked, change, word = planner.deliberate(route, driver, ego, objects, signals, time, interval, trajectory)
    return action_for(driver.parameters, asked, ego.speed), change, word


class Expert:
    """Drives as the modular policy does, with more caution and knowing the friction of the road.

    Its answer at a tick hardly depends on its earlier answers, so it can label the scenes that another driver meets:
    step it through all of them and say by :meth:`obeyed` what was done.
    """

    name = "expert"

    def __init__(self) -> None:
        self._parameters = expert_parameters(0.9)
        self._driver = new_driver(self._parameters)
        self._road: RouteTables | None = None
        self._time = math.nan

    def privilege(self, friction: float) -> None:
        """Tell what no sensor sees: the tyre-road ``friction`` of the next episodes; call it before :meth:`reset`."""
        self._parameters = expert_parameters(friction)
        self._driver = self._driver._replace(parameters=self._parameters.packed())

    def reset(self, route: Route) -> None:
        """Begin an episode on ``route``; all memory of earlier ones is dropped."""
        self._road = RouteTables.of(route, self._parameters)
        self._driver = new_driver(self._parameters)
        self._time = math.nan

    def step(self, scene: Scene) -> Decision:
        """Decide for one tick; brakes where the ego's own state is unusable or no route has come yet."""
        ego, road = scene.ego, self._road
        if road is None or not math.isfinite(scene.time + ego.x + ego.y + ego.yaw + ego.speed + ego.length + ego.width):
            return _STOP
        interval = scene.time - self._time
        if not 0.0 < interval <= _INTERVAL_MAX:
            interval = INTERVAL  # assumed at the first tick
        self._time = scene.time
        points = np.empty((4, prediction.FINE))
        action, change, word = _consider(
            unnamed(road),
            unnamed(self._driver),
            unnamed(ego),
            scene.objects.table,
            scene.signals,
            scene.time,
            interval,
            points,
        )
        plan = Trajectory(prediction.FINE_INTERVAL, points[0], points[1], points[2], points[3], behaviour.WORDS[word])
        return Decision(Command.from_action(action, change_lane=change), plan)

    def obeyed(self, *, change: bool) -> None:
        """Say whether the driver that was advised has begun the lane change at the last scene."""
        m = self._driver.memory[0]
        if not change and m["changing"] > 0.0 and m["progress"] == 0.0 and m["change_length"] == 0.0:
            m["changing"] = 0.0
        elif change and m["changing"] == 0.0:
            m["changing"], m["progress"], m["change_length"], m["change_begin"] = 1.0, 0.0, 0.0, m["s"]
