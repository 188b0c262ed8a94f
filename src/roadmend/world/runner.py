"""Runs whole episodes in this process: world, policy and repairer without ROS."""

from collections.abc import Callable

from roadmend.core.command import Command, Decision
from roadmend.core.episode_result import EpisodeResult, ResultBuilder
from roadmend.core.interfaces import Policy, Repairer
from roadmend.core.repair import Repair
from roadmend.core.route import Route
from roadmend.core.tick import Tick
from roadmend.world.scenario import Scenario
from roadmend.world.simulation import Simulation

Watcher = Callable[[Tick, Decision, Repair], None]


def run_episode(
    scenario: Scenario,
    policy: Policy,
    repairer: Repairer,
    watcher: Watcher | None = None,
    ending: Callable[[Tick], None] | None = None,
    opening: Callable[[Route], None] | None = None,
) -> EpisodeResult:
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
) -> EpisodeResult:
    """Drive a simulation that has just been opened to its end; see :func:`run_episode`.

    Raises:
        SimulationError: SUMO failed.
    """
    builder = ResultBuilder(simulation.scenario.name, policy.name, repairer.name)
    policy.reset(simulation.route)
    repairer.reset(simulation.route)
    tick = simulation.first()
    builder.see(tick)
    while tick.final is None:
        decision = policy.step(tick.scene)
        repair = repairer.step(tick.scene, decision)
        if watcher is not None:
            watcher(tick, decision, repair)
        builder.repair(repair)
        builder.command(tick, repair.command)
        tick = simulation.step(repair.command)
        builder.see(tick)
    if ending is not None:
        ending(tick)
    builder.command(tick, Command(0.0, 0.0))
    return builder.result()
