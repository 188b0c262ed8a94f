"""SUMO stepping by itself: the yardstick for the loop around it."""

import contextlib
import time
from collections.abc import Callable, Iterator
from typing import Any

import libsumo

from roadmend.world.scenario import Scenario
from roadmend.world.simulation import Simulation

_SETTERS = (
    "changeLane",
    "changeSublane",
    "moveToXY",
    "setAccel",
    "setDecel",
    "setLaneChangeMode",
    "setSpeed",
    "setSpeedFactor",
    "setSpeedMode",
    "slowDown",
)

Call = tuple[Callable[..., Any], tuple[Any, ...]]
Script = list[list[Call]]


@contextlib.contextmanager
def recorded_orders() -> Iterator[Script]:
    """While this lasts, note every order that is given to SUMO's vehicles, by step.

    Element k of the result holds the orders before step k.
    """
    script: Script = [[]]
    vehicle, simulation = libsumo.vehicle, libsumo.simulation
    before = {name: getattr(vehicle, name) for name in _SETTERS}
    step = simulation.step

    def note(order: Callable[..., Any]) -> Callable[..., Any]:
        def give(*arguments: Any) -> Any:
            script[-1].append((order, arguments))
            return order(*arguments)

        return give

    def count(*arguments: Any) -> Any:
        script.append([])
        return step(*arguments)

    for name, order in before.items():
        setattr(vehicle, name, note(order))
    simulation.step = count
    try:
        yield script
    finally:
        simulation.step = step
        for name, order in before.items():
            setattr(vehicle, name, order)


def time_bare_stepping(scenario: Scenario, script: Script) -> float:
    """Seconds that SUMO's steps of a recorded episode take when nothing is read and nothing decided.

    The orders of the recording are given again, outside the timing, so that the traffic is the very same.

    Raises:
        InputError: the scenario cannot be run.
    """
    total = 0.0
    with Simulation(scenario):
        step = libsumo.simulation.step
        for orders in script[:-1]:
            for order, arguments in orders:
                order(*arguments)
            begin = time.perf_counter()
            step()
            total += time.perf_counter() - begin
    return total
