"""Runs whole episodes in this process: world, policy and repairer without ROS."""

import hashlib
import math
import struct
import time
from collections.abc import Callable
from dataclasses import dataclass, field

from roadmend.core.command import Command, Decision
from roadmend.core.interfaces import Policy, Repairer
from roadmend.core.outcome import Event, EventKind
from roadmend.core.repair import Repair
from roadmend.core.route import Route
from roadmend.core.tick import INTERVAL, Tick
from roadmend.world.scenario import Scenario
from roadmend.world.simulation import Simulation

Watcher = Callable[[Tick, Decision, Repair], None]


class TrajectoryDigest:
    """SHA-256 over what the ego did and what it was told, tick by tick: equal digests mean bit-identical runs."""

    def __init__(self) -> None:
        self._hash = hashlib.sha256()

    def add(self, time: float, x: float, y: float, yaw: float, speed: float, throttle: float, brake: float) -> None:
        """Add one tick."""
        self._hash.update(struct.pack("<7d", time, x, y, yaw, speed, throttle, brake))

    @property
    def hexadecimal(self) -> str:
        """The digest so far."""
        return self._hash.hexdigest()


@dataclass
class EpisodeSummary:
    """What an episode came to; shared by the in-process runner and the simulator node."""

    scenario: str
    outcome: EventKind = EventKind.ABORTED
    text: str = ""
    ticks: int = 0
    duration: float = 0.0  # [s] simulation time
    min_distance: float = float("inf")  # [m]
    interventions: int = 0  # ticks whose command was replaced
    intensity: float = 0.0  # mean |policy action - final action| over those ticks
    dose: float = 0.0  # [s] sum of |policy action - final action| * interval
    digest: str = ""
    events: list[Event] = field(default_factory=list)
    finite: bool = True  # whether every pose and command so far was a finite number
    loop_ended: float = 0.0  # [s] time.perf_counter() after the last tick, for benchmarks
    _change: float = 0.0

    def add(self, policy_action: float, final_action: float, *, intervened: bool) -> None:
        """Count one tick's command."""
        self.finite = self.finite and math.isfinite(final_action)
        if intervened:
            self.interventions += 1
            self._change += abs(policy_action - final_action)
            self.intensity = self._change / self.interventions
            self.dose = self._change * INTERVAL

    def observe(self, tick: Tick) -> None:
        """Count one tick's scene."""
        ego = tick.scene.ego
        self.finite = self.finite and math.isfinite(ego.x + ego.y + ego.yaw + ego.speed)
        self.ticks = tick.number
        self.duration = tick.scene.time
        self.min_distance = min(self.min_distance, tick.min_distance)
        self.events += tick.events
        if tick.final is not None:
            self.outcome = tick.final.kind
            self.text = tick.final.text


def run_episode(
    scenario: Scenario,
    policy: Policy,
    repairer: Repairer,
    watcher: Watcher | None = None,
    ending: Callable[[Tick], None] | None = None,
    opening: Callable[[Route], None] | None = None,
) -> EpisodeSummary:
    """Run a scenario to its end.

    Args:
        scenario: what to run.
        policy: decides at every tick.
        repairer: stands between the policy and the vehicle.
        watcher: called at every tick before the vehicle moves, with what was seen and decided.
        ending: called with the final tick, which nobody answers.
        opening: called with the ego's route before the first tick.

    Raises:
        InputError: the scenario cannot be run.
        SimulationError: SUMO failed.
    """
    with Simulation(scenario) as simulation:
        if opening is not None:
            opening(simulation.route)
        return drive(simulation, policy, repairer, watcher, ending)


def drive(
    simulation: Simulation,
    policy: Policy,
    repairer: Repairer,
    watcher: Watcher | None = None,
    ending: Callable[[Tick], None] | None = None,
) -> EpisodeSummary:
    """Drive a simulation that has just been opened to its end; see :func:`run_episode`.

    Raises:
        SimulationError: SUMO failed.
    """
    summary = EpisodeSummary(simulation.scenario.name)
    digest = TrajectoryDigest()
    policy.reset(simulation.route)
    repairer.reset(simulation.route)
    tick = simulation.first()
    summary.observe(tick)
    while tick.final is None:
        decision = policy.step(tick.scene)
        repair = repairer.step(tick.scene, decision)
        if watcher is not None:
            watcher(tick, decision, repair)
        summary.add(repair.policy_action, repair.final_action, intervened=repair.intervened)
        add_tick(digest, tick, repair.command)
        tick = simulation.step(repair.command)
        summary.observe(tick)
    summary.loop_ended = time.perf_counter()
    if ending is not None:
        ending(tick)
    add_tick(digest, tick, Command(0.0, 0.0))
    summary.digest = digest.hexadecimal
    return summary


def add_tick(digest: TrajectoryDigest, tick: Tick, command: Command) -> None:
    """Add what was seen and answered at one tick to a digest."""
    ego = tick.scene.ego
    digest.add(tick.scene.time, ego.x, ego.y, ego.yaw, ego.speed, command.throttle, command.brake)
