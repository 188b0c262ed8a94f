"""Steps per second of roadmend/Drive-v0 in one process and in workers, beside the runner's in this process.

    .venv/bin/python src/examples/steps_per_second.py

On a machine that others use, compare what the first two take of their own processor time. Every figure is of episodes of
the same scenarios, the roads built and the kernels compiled before; what it takes to begin an episode counts, what it
takes to start the processes does not.
"""

import sys
import time
from collections.abc import Callable

import numpy as np

from roadmend import Command, Decision, Route, Scenario, Scene, Trajectory, run, sample_scenario
from roadmend.gym import DriveEnv, make_vector

PUSH = 0.3  # throttle of whoever drives: no policy's time counts
FAMILY, COUNT = "S3", 5


class Push:
    """Drives on, whatever there is."""

    name = "push"

    def reset(self, route: Route) -> None:
        """Nothing is remembered."""

    def step(self, scene: Scene) -> Decision:
        """The same command at every tick."""
        return Decision(Command.from_action(float(np.float32(PUSH)), change_lane=True), Trajectory.empty())


def of_runner(scenarios: list[Scenario], steps: int, clock: Callable[[], float] = time.perf_counter) -> float:
    """Steps per second of ``roadmend.run``, without repair."""
    done, begin = 0, clock()
    while done < steps:
        done += run(scenarios[0], Push(), "none").ticks
        scenarios.append(scenarios.pop(0))
    return done / (clock() - begin)


def of_environment(steps: int, clock: Callable[[], float] = time.perf_counter) -> float:
    """Steps per second of one environment in this process."""
    env, action = DriveEnv(families=[FAMILY], count=COUNT), np.full(1, PUSH, dtype=np.float32)
    env.reset(seed=0)
    begin = clock()
    for _ in range(steps):
        if any(env.step(action)[2:4]):
            env.reset()
    spent = clock() - begin
    env.close()
    return steps / spent


def of_workers(workers: int, steps: int) -> float:
    """Steps per second of all workers together."""
    vector, action = make_vector(workers, families=[FAMILY], count=COUNT), np.full((workers, 1), PUSH, dtype=np.float32)
    try:
        vector.reset(seed=0)
        for _ in range(10):
            vector.step(action)
        begin = time.perf_counter()
        for _ in range(steps // workers):
            vector.step(action)
        return steps // workers * workers / (time.perf_counter() - begin)
    finally:
        vector.close()


def main(steps: int = 4000, rounds: int = 3) -> None:
    """Print the middle one of some rounds, in which the ways take turns."""
    scenarios = [sample_scenario(FAMILY, number) for number in range(COUNT)]
    of_runner(scenarios, 1)
    ways = {
        "the runner, in this process": lambda: of_runner(scenarios, steps),
        "one environment, in this process": lambda: of_environment(steps),
        "1 worker": lambda: of_workers(1, steps),
        "2 workers": lambda: of_workers(2, steps),
        "the runner, by its processor time": lambda: of_runner(scenarios, steps, time.process_time),
        "one environment, by its processor time": lambda: of_environment(steps, time.process_time),
    }
    found: dict[str, list[float]] = {name: [] for name in ways}
    for number in range(rounds):
        for name, way in ways.items():
            found[name].append(way())
            print(f"round {number + 1}, {name}: {found[name][-1]:.0f} steps/s", file=sys.stderr)
    for name, rates in found.items():
        print(f"{name}: {sorted(rates)[len(rates) // 2]:.0f} steps/s ({min(rates):.0f} .. {max(rates):.0f})")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:3]))
