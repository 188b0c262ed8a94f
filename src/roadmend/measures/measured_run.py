"""An episode in this process with its four measures."""

from roadmend.core.command import Decision
from roadmend.core.interfaces import Policy
from roadmend.core.repair import Repair
from roadmend.core.route import Route
from roadmend.core.tick import Tick
from roadmend.measures.driving import DrivingMeasures, MeasuresObserver
from roadmend.repair.registry import make_repairer
from roadmend.world.runner import run_episode
from roadmend.world.scenario import Scenario


def measured_run(scenario: Scenario, policy: Policy) -> DrivingMeasures:
    """Drive a scenario without repair.

    Raises:
        InputError: the scenario cannot be run.
        SimulationError: SUMO failed.
    """
    run = _Run()
    run_episode(scenario, policy, make_repairer("none"), run.answered, run.ended, run.opened)
    return run.measures()


class _Run:
    observer: MeasuresObserver
    last: Tick

    def opened(self, route: Route) -> None:
        self.observer = MeasuresObserver(route)

    def answered(self, tick: Tick, _decision: Decision, _repair: Repair) -> None:
        self.observer.see(tick.scene)

    def ended(self, tick: Tick) -> None:
        self.observer.see(tick.scene)
        self.last = tick

    def measures(self) -> DrivingMeasures:
        assert self.last.final is not None
        return self.observer.measures(self.last.final)
