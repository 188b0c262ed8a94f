"""The modular driving policy: localisation, prediction, behaviour, planner and controller in one compiled step."""

import math

import numpy as np
from numpy.typing import NDArray

from roadmend.core.command import Command, Decision, Trajectory
from roadmend.core.jit import compiled
from roadmend.core.route import Route
from roadmend.core.scene import Scene
from roadmend.policies import agents as who
from roadmend.policies import behaviour, controller, localisation, planner, prediction
from roadmend.policies import path as way
from roadmend.policies.parameters import ModularParameters
from roadmend.policies.road import Road

Floats = NDArray[np.float64]
Record = NDArray[np.void]

_INTERVAL = 0.05  # [s] between ticks, assumed at the first one
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


def new_memory() -> Record:
    """The memory of a policy at the beginning of an episode."""
    memory: Record = np.zeros(1, dtype=np.dtype([(name, np.float64) for name in _MEMORY], align=True))
    memory[0] = tuple(_MEMORY.values())
    return memory


@compiled
def _drive(
    samples: Floats,
    stages: Floats,
    zones: Floats,
    parameters: Record,
    memory: Record,
    known: NDArray[np.uint32],
    known_curvature: Floats,
    time: float,
    interval: float,
    tick: float,
    x: float,
    y: float,
    yaw: float,
    speed: float,
    length: float,
    width: float,
    numbers: NDArray[np.uint32],
    kind: NDArray[np.uint8],
    object_x: Floats,
    object_y: Floats,
    object_yaw: Floats,
    object_speed: Floats,
    object_acceleration: Floats,
    object_yaw_rate: Floats,
    object_length: Floats,
    object_width: Floats,
    signals: NDArray[np.uint8],
    trajectory: Floats,
) -> tuple[float, float, bool, int]:
    """A new plan: one pass through all modules, ``interval`` [s] after the last and ``tick`` [s] after the last tick.

    Returns throttle, brake, whether to change lane and the word's index.
    """
    m = memory[0]
    half = 0.5 * length
    stage = m.stage
    localisation.localise(samples, stages, parameters, memory, x, y, speed)
    if stage >= 0.0 and m.stage > stage:
        m.changed_at = time
    path = way.build_path(samples, stages, parameters, memory, speed, length, width)
    spacing = way.path_spacing(speed)
    tracks, remembered = prediction.track(
        parameters,
        numbers,
        kind,
        object_x,
        object_y,
        object_yaw,
        object_speed,
        object_acceleration,
        object_yaw_rate,
        object_length,
        object_width,
        known,
        known_curvature,
        int(m.known_count),
        interval,
        x,
        y,
        spacing * way.POINTS,
    )
    m.known_count = remembered
    count = tracks.shape[0]
    forecasts = np.empty((count, prediction.TIMES, prediction.FORECAST_COLUMNS), dtype=np.float64)
    occupancies = np.empty((count, prediction.TIMES, 2), dtype=np.float64)
    agents = np.empty((count, who.AGENT_COLUMNS), dtype=np.float64)
    plan = np.empty((prediction.TIMES, 2), dtype=np.float64)
    who.assess(
        path,
        spacing,
        zones,
        parameters,
        memory,
        signals,
        tracks,
        x,
        y,
        yaw,
        half,
        forecasts,
        occupancies,
        agents,
    )
    lead, gap, braking, most, cap, line, word, change = behaviour.decide(
        samples,
        stages,
        zones,
        path,
        spacing,
        parameters,
        memory,
        signals,
        tracks,
        forecasts,
        occupancies,
        agents,
        time,
        speed,
        half,
        0.5 * width,
        interval,
        plan,
    )
    if change:
        m.changing, m.progress, m.change_length, m.change_begin = 1.0, 0.0, 0.0, m.s
    asked, evades = planner.plan_motion(
        path,
        spacing,
        parameters,
        memory,
        agents,
        forecasts,
        occupancies,
        lead,
        gap,
        braking,
        most,
        cap,
        line,
        speed,
        half,
        zones,
        plan,
    )
    if evades:
        word = behaviour.EVADE
        if speed < 0.5:
            m.waited += interval
    wanted = planner.smooth(parameters, memory, asked, speed, interval)
    throttle, brake = controller.control(parameters, memory, wanted, speed, tick)
    planner.write_trajectory(path, spacing, plan, trajectory)
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
        self._packed = self.parameters.packed()
        self._memory = np.zeros(1, dtype=np.dtype([(name, np.float64) for name in _MEMORY], align=True))
        self._known = np.zeros(prediction.REMEMBERED, dtype=np.uint32)
        self._known_curvature = np.zeros(prediction.REMEMBERED)
        self._road: Road | None = None
        self._time = math.nan
        self._planned_at = math.nan
        self._trajectory = Trajectory.empty()

    def reset(self, route: Route) -> None:
        """Begin an episode on ``route``; all memory of earlier ones is dropped."""
        self._road = Road.of(route, self.parameters)
        self._forget()

    def _forget(self) -> None:
        self._memory[0] = tuple(_MEMORY.values())
        self._time = self._planned_at = math.nan

    def step(self, scene: Scene) -> Decision:
        """Decide for one tick; brakes where the ego's own state is unusable or no route has come yet."""
        ego, objects, road = scene.ego, scene.objects, self._road
        if road is None or not math.isfinite(scene.time + ego.x + ego.y + ego.yaw + ego.speed + ego.length + ego.width):
            return _STOP
        interval = scene.time - self._time
        if not 0.0 < interval <= _INTERVAL_MAX:
            if interval < 0.0 or interval > _INTERVAL_MAX:
                self._forget()
            interval = _INTERVAL
        self._time = scene.time
        since = scene.time - self._planned_at
        if since < self.parameters.planning_interval - 1e-6:
            throttle, brake = _hold(self._packed, self._memory, ego.speed, interval)
            return Decision(Command(throttle, brake), self._trajectory)
        self._planned_at = scene.time
        points = np.empty((4, prediction.FINE))
        throttle, brake, change, word = _drive(
            road.samples,
            road.stages,
            road.zones,
            self._packed,
            self._memory,
            self._known,
            self._known_curvature,
            scene.time,
            interval if math.isnan(since) else since,
            interval,
            ego.x,
            ego.y,
            ego.yaw,
            ego.speed,
            ego.length,
            ego.width,
            objects.id,
            objects.kind,
            objects.x,
            objects.y,
            objects.yaw,
            objects.speed,
            objects.acceleration,
            objects.yaw_rate,
            objects.length,
            objects.width,
            scene.signals,
            points,
        )
        self._trajectory = Trajectory(
            prediction.FINE_INTERVAL, points[0], points[1], points[2], points[3], behaviour.WORDS[word]
        )
        return Decision(Command(throttle, brake, change), self._trajectory)
