"""Futures of a moment: continuations of an episode that differ as the world may differ from then on."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

from roadmend.core.branch import branch
from roadmend.core.command import Decision
from roadmend.core.errors import InputError
from roadmend.core.interfaces import Policy, Repairer
from roadmend.core.outcome import Event, EventKind
from roadmend.core.tick import INTERVAL, Tick
from roadmend.world.simulation import Simulation
from roadmend.world.variation import Spread

USUAL = Spread()


@dataclass(frozen=True, slots=True)
class Moment:
    """Where an episode stands: everything that it goes on from."""

    simulation: Simulation  # that stands at ``tick``
    tick: Tick
    decision: Decision  # of the policy at ``tick``
    policy: Policy  # that has just decided


@dataclass(frozen=True, slots=True)
class Future:
    """What one continuation came to."""

    final: Event | None  # how it ended; None where it went on beyond the horizon
    duration: float  # [s] from the moment to the end, or the horizon
    x: float  # [m] the ego's place and speed then, which tell futures apart
    y: float  # [m]
    speed: float  # [m/s]
    driven: float  # [m] that the ego went until then

    @property
    def violates(self) -> bool:
        """Whether the ego collides by its own fault."""
        return self.collides and self.final is not None and self.final.at_fault

    @property
    def collides(self) -> bool:
        """Whether the ego collides, whosever fault it is."""
        return self.final is not None and self.final.kind is EventKind.COLLISION


def futures(
    moment: Moment, repairer: Repairer, seeds: Sequence[int | None], horizon: float, spread: Spread = USUAL
) -> list[Future]:
    """Continue an episode several times; the episode itself stays where it is.

    A future follows from the scenario, the moment and its seed, in whatever process and whatever others there are.

    Args:
        moment: from where.
        repairer: stands between from now on, as it is before it has seen the tick. A policy that is left alone has the
            method "none", as where it is driven: its guard makes the commands valid.
        seeds: of what differs, one a future; None for what will be, where nothing differs.
        horizon: [s] after which nothing counts.
        spread: how far the futures lie apart.

    Raises:
        SimulationError: SUMO failed in one of them.
    """
    return [branch(partial(_go_on, moment, repairer, seed, horizon, spread)) for seed in seeds]


def moment_at(simulation: Simulation, policy: Policy, repairer: Repairer, number: int) -> Moment:
    """Drive a simulation that has just been opened to a tick.

    Args:
        simulation: that nobody has driven in.
        policy: who drives.
        repairer: stands between; has not seen the tick in the end.
        number: of the tick.

    Raises:
        InputError: the episode ends before.
        SimulationError: SUMO failed.
    """
    policy.reset(simulation.route)
    repairer.reset(simulation.route)
    tick = simulation.first()
    while tick.final is None:
        decision = policy.step(tick.scene)
        if tick.number == number:
            return Moment(simulation, tick, decision, policy)
        tick = simulation.step(repairer.step(tick.scene, decision).command)
    raise InputError(simulation.scenario.name, f"ends before {number * INTERVAL:g} s", "drive it again")


def share_of_violations(found: Sequence[Future]) -> float:
    """Share of the futures in which the ego collides by its own fault; 0 of none."""
    return sum(future.violates for future in found) / len(found) if found else 0.0


def _go_on(moment: Moment, repairer: Repairer, seed: int | None, horizon: float, spread: Spread) -> Future:
    simulation, tick, decision = moment.simulation, moment.tick, moment.decision
    if seed is not None:
        simulation.vary(seed, spread)
    begin, last = tick.number, tick.number + round(horizon / INTERVAL)
    driven = 0.0
    while tick.final is None and tick.number < last:
        tick = simulation.step(repairer.step(tick.scene, decision).command)
        driven += tick.scene.ego.speed * INTERVAL
        if tick.final is None:
            decision = moment.policy.step(tick.scene)
    ego = tick.scene.ego
    return Future(tick.final, (tick.number - begin) * INTERVAL, ego.x, ego.y, ego.speed, driven)
