"""An episode in this process with its four measures."""

from typing import Protocol

from roadmend.core.command import Decision
from roadmend.core.episode_result import EpisodeResult
from roadmend.core.interfaces import Policy, Repairer
from roadmend.core.repair import Repair
from roadmend.core.route import Route
from roadmend.core.tick import Tick
from roadmend.measures.driving import DrivingMeasures, MeasuresObserver
from roadmend.world.runner import run_episode
from roadmend.world.scenario import Scenario


class EpisodeObserver(Protocol):
    """Hears what the runner reports."""

    def opened(self, route: Route) -> None:
        """The episode begins."""

    def answered(self, tick: Tick, decision: Decision, repair: Repair) -> None:
        """A tick was decided."""

    def ended(self, tick: Tick) -> None:
        """The final tick was reached."""


def measured_run(
    scenario: Scenario, policy: Policy, repairer: Repairer, *observers: EpisodeObserver
) -> tuple[EpisodeResult, DrivingMeasures]:
    """Drive a scenario and tell what it came to, and its measures.

    Raises:
        InputError: the scenario cannot be run.
        SimulationError: SUMO failed.
    """
    measuring: list[MeasuresObserver] = []

    def opened(route: Route) -> None:
        measuring.append(MeasuresObserver(route))
        for observer in observers:
            observer.opened(route)

    def answered(tick: Tick, decision: Decision, repair: Repair) -> None:
        measuring[0].see(tick.scene)
        for observer in observers:
            observer.answered(tick, decision, repair)

    def ended(tick: Tick) -> None:
        measuring[0].see(tick.scene)
        for observer in observers:
            observer.ended(tick)

    result = run_episode(scenario, policy, repairer, answered, ended, opened)
    return result, measuring[0].measures(result.final)
