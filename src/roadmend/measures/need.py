"""Need of a spell: share of the futures of its first tick, the policy left alone, that violate within HORIZON."""

from dataclasses import replace

from roadmend.core.command import Decision
from roadmend.core.episode_result import EpisodeResult
from roadmend.core.interfaces import Policy, Repairer
from roadmend.core.repair import Repair
from roadmend.core.spell import SpellBuilder
from roadmend.core.tick import Tick
from roadmend.world.futures import Moment, futures, share_of_violations
from roadmend.world.runner import drive
from roadmend.world.scenario import Scenario
from roadmend.world.simulation import Simulation

HORIZON = 8.0  # [s]
NEEDLESS = 0.1  # need below which a spell is called so


def run_with_need(scenario: Scenario, policy: Policy, repairer: Repairer, count: int) -> EpisodeResult:
    """Drive a scenario and tell the need of every spell, from ``count`` futures each; else as ``run_episode``.

    Raises:
        InputError: the scenario cannot be run.
        SimulationError: SUMO failed.
    """
    needs: dict[float, float] = {}
    spells = SpellBuilder()
    with Simulation(scenario) as simulation:

        def watch(tick: Tick, decision: Decision, repair: Repair) -> None:
            if spells.add(tick.scene.time, repair):
                found = futures(Moment(simulation, tick, decision, policy), None, range(1, count + 1), HORIZON)
                needs[tick.scene.time] = share_of_violations(found)

        result = drive(simulation, policy, repairer, watch)
    return replace(result, spells=tuple(replace(spell, need=needs[spell.begin]) for spell in result.spells))
