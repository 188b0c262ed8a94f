"""What would come without repair: need of an intervention, persistence of a violation.

Need of a spell: share of the futures of its first tick, the policy left alone, that violate within HORIZON. Persistence
of a violation: share of the futures of the tick HORIZON before it that violate again, by LATER after it at the latest.
"""

from dataclasses import replace

from roadmend.core.command import Decision
from roadmend.core.episode_result import EpisodeResult
from roadmend.core.interfaces import Policy, Repairer
from roadmend.core.repair import Repair
from roadmend.core.spell import SpellBuilder
from roadmend.core.tick import INTERVAL, Tick
from roadmend.repair.registry import make_repairer
from roadmend.world.futures import Moment, futures, moment_at, share_of_violations
from roadmend.world.runner import drive
from roadmend.world.scenario import Scenario
from roadmend.world.simulation import Simulation

HORIZON = 8.0  # [s]
LATER = 2.0  # [s] by which a violation may come later in another future
PERSISTENT = 0.8  # persistence from which a violation is called so


def run_with_need(scenario: Scenario, policy: Policy, repairer: Repairer, count: int) -> EpisodeResult:
    """Drive a scenario and tell the need of every spell, from ``count`` futures each; else as ``run_episode``.

    Raises:
        InputError: the scenario cannot be run.
        SimulationError: SUMO failed.
    """
    needs: dict[float, float] = {}
    spells, alone = SpellBuilder(), make_repairer("none")
    with Simulation(scenario) as simulation:

        def watch(tick: Tick, decision: Decision, repair: Repair) -> None:
            if spells.add(tick.scene.time, repair):
                alone.reset(simulation.route)
                found = futures(Moment(simulation, tick, decision, policy), alone, range(1, count + 1), HORIZON)
                needs[tick.scene.time] = share_of_violations(found)

        result = drive(simulation, policy, repairer, watch)
    return replace(result, spells=tuple(replace(spell, need=needs[spell.begin]) for spell in result.spells))


def persistence(scenario: Scenario, policy: Policy, end: float, count: int) -> float:
    """Share of ``count`` futures of a violation at ``end`` [s] that violate again.

    Args:
        scenario: in which the policy alone violates at ``end``.
        policy: who does.
        end: [s] of the violation; before HORIZON has passed the futures begin with the first tick.
        count: of futures.

    Raises:
        InputError: the scenario cannot be run, or ends before.
        SimulationError: SUMO failed.
    """
    begin = max(0, round((end - HORIZON) / INTERVAL))
    alone = make_repairer("none")
    with Simulation(scenario) as simulation:
        moment = moment_at(simulation, policy, alone, begin)
        return share_of_violations(futures(moment, alone, range(1, count + 1), end - moment.tick.scene.time + LATER))
