"""What the repair of one frame costs: all methods side by side in one run, so that their ratios mean something."""

import gc
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import cast

import numpy as np
from numpy.typing import NDArray

from roadmend.core.command import Decision
from roadmend.core.interfaces import Repairer
from roadmend.core.repair import Repair, RepairStatus
from roadmend.core.route import Route
from roadmend.core.scene import EgoState, ObjectKind, ObjectList, Scene
from roadmend.core.tick import INTERVAL, Tick
from roadmend.policies.registry import make_policy
from roadmend.repair.guard import GuardedRepairer
from roadmend.repair.method import RepairMethod
from roadmend.repair.none import NoRepair
from roadmend.world.families import FAMILIES, sample_scenario
from roadmend.world.runner import run_episode

Times = NDArray[np.float64]

_RADIUS = 80.0  # [m] around where the ego begins: there the participants are put that a scene lacks
_FIRST_ADDED = 1_000_000  # id of the first of these
_UNTIMED = 20  # frames before the clock starts: the first ones load machine code and fill caches


@dataclass(frozen=True, slots=True, eq=False)
class Moment:
    """One frame to repair. Moments of one episode stand together, in order, and share the route."""

    route: Route
    scene: Scene
    decision: Decision


class _Recorder(GuardedRepairer):
    """Repairs nothing and remembers the route."""

    def __init__(self) -> None:
        super().__init__(NoRepair())
        self.route: Route | None = None

    def reset(self, route: Route) -> None:
        self.route = route
        super().reset(route)


def gather_moments(policy: str = "modular", objects: int = 20, ticks: int = 100, seed: int = 0) -> list[Moment]:
    """Frames of one scenario of each family, every one with the same number of participants.

    The nearest are kept where there are too many. Where there are too few, further ones are put around the start of
    the ego, at random, and move with constant velocity.

    Args:
        policy: drives, without repair.
        objects: participants in every frame.
        ticks: frames of each family; fewer where the episode ends before.
        seed: of the scenarios and of the added participants.

    Raises:
        InputError: there is no such policy.
    """
    moments: list[Moment] = []
    for number, family in enumerate(FAMILIES):
        scenario = sample_scenario(family, seed).model_copy(update={"time_limit": ticks * INTERVAL})
        recorder = _Recorder()
        seen: list[tuple[Scene, Decision]] = []

        def note(tick: Tick, decision: Decision, _repair: Repair, seen: list[tuple[Scene, Decision]] = seen) -> None:
            seen.append((tick.scene, decision))

        run_episode(scenario, make_policy(policy), recorder, note)
        if recorder.route is None or not seen:
            continue
        crowd = _crowd(objects, seen[0][0].ego, np.random.default_rng([seed, number]))
        for scene, decision in seen:
            populated = replace(scene, objects=_populate(scene, crowd, objects))
            moments.append(Moment(recorder.route, populated, decision))
    return moments


def measure_cost(
    methods: Mapping[str, Callable[[], RepairMethod | Repairer]],
    moments: Sequence[Moment],
    rounds: int = 3,
    reference: str | None = None,
) -> dict[str, dict[str, float]]:
    """Time single frames: from the scene and the policy's decision to the repaired command, in this process.

    At every frame each method answers once, and each time another one is the first, so that whatever else the machine
    does falls on all alike. All see the same frames. A method that is no Repairer is timed behind the guard, as it
    runs in the graph. The garbage collector waits meanwhile. Methods that use threads must be told to use one.

    Args:
        methods: how each is made, by name. A network in plain torch, to compare with, is one of them.
        moments: the frames, as ``gather_moments`` gives them.
        rounds: how often all frames are gone through.
        reference: name of the method whose median the others are to be divided by.

    Returns:
        For each name "median_ms" and "p99_ms" over rounds x moments, by the wall clock; "cpu_median_ms" and
        "cpu_p99_ms", by the time that this thread had a core, which other programs on the machine stretch far less; and
        with a reference "ratio": its own median_ms over the reference's.

    Raises:
        RuntimeError: a method failed, so that what was timed is not its own answer.
        ValueError: there are no moments.
    """
    if not moments:
        raise ValueError("no moments to measure on")
    repairers = {name: _repairer(make()) for name, make in methods.items()}
    for repairer in repairers.values():
        if isinstance(repairer, GuardedRepairer):
            repairer.warm_up()
    _time_round(repairers, moments[:_UNTIMED])
    collected: dict[str, list[Times]] = {name: [] for name in repairers}
    running = gc.isenabled()
    gc.collect()
    gc.disable()
    try:
        for _ in range(rounds):
            for name, times in _time_round(repairers, moments).items():
                collected[name].append(times)
    finally:
        if running:
            gc.enable()
    result: dict[str, dict[str, float]] = {}
    for name, parts in collected.items():
        times = np.concatenate(parts, axis=1) * 1e3
        (median, cpu_median), (p99, cpu_p99) = np.percentile(times, (50.0, 99.0), axis=1).tolist()
        result[name] = {"median_ms": median, "p99_ms": p99, "cpu_median_ms": cpu_median, "cpu_p99_ms": cpu_p99}
    if reference is not None:
        unit = result[reference]["median_ms"]
        for figures in result.values():
            figures["ratio"] = figures["median_ms"] / unit
    return result


def _repairer(made: RepairMethod | Repairer) -> Repairer:
    # Not isinstance: both are protocols, and a class may serve as either without naming one.
    return cast("Repairer", made) if hasattr(made, "step") else GuardedRepairer(made)


def _time_round(repairers: Mapping[str, Repairer], moments: Sequence[Moment]) -> dict[str, Times]:
    """Seconds of every frame by the wall clock and by the thread's own, shape (2, moments), by name."""
    names = list(repairers)
    times = {name: np.empty((2, len(moments))) for name in names}
    route: Route | None = None
    for index, moment in enumerate(moments):
        if moment.route is not route:
            route = moment.route
            for repairer in repairers.values():
                repairer.reset(route)
        first = index % max(1, len(names))
        for name in names[first:] + names[:first]:
            step = repairers[name].step
            own_begin = time.thread_time()
            begin = time.perf_counter()
            repair = step(moment.scene, moment.decision)
            end = time.perf_counter()
            times[name][:, index] = end - begin, time.thread_time() - own_begin
            if repair.status is RepairStatus.MODEL_FAULT:
                raise RuntimeError(f"{name} failed on frame {index}: {repair.reason}")
    return times


def _crowd(count: int, ego: EgoState, rng: np.random.Generator) -> ObjectList:
    """Cars around a place, none of them upon it."""
    angle = rng.uniform(-np.pi, np.pi, count)
    distance = _RADIUS * np.sqrt(rng.uniform(0.02, 1.0, count))
    return ObjectList.of(
        id=np.arange(_FIRST_ADDED, _FIRST_ADDED + count),
        kind=ObjectKind.CAR,
        x=ego.x + distance * np.cos(angle),
        y=ego.y + distance * np.sin(angle),
        yaw=rng.uniform(-np.pi, np.pi, count),
        speed=rng.uniform(0.0, 12.0, count),
        acceleration=0.0,
        yaw_rate=0.0,
        length=4.5,
        width=1.8,
    )


def _populate(scene: Scene, crowd: ObjectList, count: int) -> ObjectList:
    """The nearest participants of a scene, and of the crowd as many as are missing."""
    found = scene.objects
    if len(found) >= count:
        distance = np.hypot(found.x - scene.ego.x, found.y - scene.ego.y)
        return found.select(np.sort(np.argsort(distance, kind="stable")[:count]))
    added = crowd.select(np.arange(count - len(found)))
    way = added.speed * scene.time
    added = added.with_columns(x=added.x + way * np.cos(added.yaw), y=added.y + way * np.sin(added.yaw))
    return ObjectList(np.concatenate([found.table, added.table]))
