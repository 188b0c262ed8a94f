"""SUMO stepping by itself: the yardstick for the loop around it."""

import time

import libsumo

from roadmend.world.scenario import Scenario
from roadmend.world.simulation import Simulation


def time_bare_stepping(scenario: Scenario, ticks: int) -> float:
    """Seconds that ``ticks`` SUMO steps of a scenario take when nothing is read and nobody is steered.

    The same network, traffic, options and number of vehicles; the ego is left to SUMO's own driver.

    Raises:
        InputError: the scenario cannot be run.
    """
    with Simulation(scenario):
        step = libsumo.simulation.step
        libsumo.vehicle.setSpeedMode("ego", 31)
        step()
        begin = time.perf_counter()
        for _ in range(ticks):
            step()
        return time.perf_counter() - begin
