"""What is done with crash reports, cut into jobs: one scenario to build or to drive, or one crash to reproduce."""

import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from enum import StrEnum
from pathlib import Path
from typing import Any, Self

from roadmend.core.errors import RoadmendError
from roadmend.core.journal import Key, entry_key
from roadmend.measures.driver import driver_key
from roadmend.safe.construction import Role, draw_scenario
from roadmend.safe.reproduction import reproduce
from roadmend.safe.trial import Trial, run_trial
from roadmend.world.scenario import Scenario
from roadmend.world.scenario_file import save_scenario
from roadmend.world.simulation import Simulation

SCENARIOS = "scenarios"  # folders in the output
PICTURES = "pictures"

Drawing = Callable[[Scenario, Trial, Path], None]  # draws an episode into a file; a function that a worker can import


class Task(StrEnum):
    """What a job does with a role of a report."""

    BUILD = "build"
    TEST = "test"
    REPRODUCE = "reproduce"


@dataclass(frozen=True, slots=True)
class Job:
    """One scenario to build or to drive, or one crash to reproduce.

    Attributes:
        task: what to do.
        role: the report, and the vehicle whose place the ego takes.
        policy: name; empty for a task that drives nobody.
        seed: of sampling, search and simulator.
        index: of the scenario among those of the role, from 0; 0 for a reproduction.
        budget: episodes of a reproduction.
        out: folder for scenarios and pictures.
        draw: draws an episode that was driven; None where no picture is wanted.
    """

    task: Task
    role: Role
    policy: str
    seed: int
    index: int
    budget: int
    out: Path
    draw: Drawing | None

    @property
    def key(self) -> Key:
        """Of everything that decides the result."""
        driver = driver_key(self.policy) if self.policy else None
        code = [__name__, *([self.draw.__module__] if self.draw is not None else [])]
        return entry_key(code, self.task, repr(self.role), driver, self.seed, self.index, self.budget)


@dataclass(frozen=True, slots=True)
class Result:
    """What a job came to; plain values.

    Attributes:
        report: name of the report.
        vehicle: number of the vehicle whose place the ego took.
        policy: name.
        scenario: file in the output folder; empty if none was built (test) or nothing reproduced.
        picture: file in the output folder, or empty.
        outcome: an EventKind's name; empty if nothing ran.
        text: how the episode ended, or why it did not run, or what a reproduction came to.
        collision: whether the ego collided.
        at_fault: whether it did by its own fault.
        reproduced: whether it was the described crash; None for a test.
        episodes: that were driven.
        seconds: wall clock, building and driving.
    """

    report: str
    vehicle: int
    policy: str
    scenario: str = ""
    picture: str = ""
    outcome: str = ""
    text: str = ""
    collision: bool = False
    at_fault: bool = False
    reproduced: bool | None = None
    episodes: int = 0
    seconds: float = 0.0

    def as_dict(self) -> dict[str, Any]:
        """As JSON holds it."""
        return asdict(self)

    @classmethod
    def from_dict(cls, content: Mapping[str, Any]) -> Self:
        """From :meth:`as_dict`."""
        return cls(**content)


def do(job: Job) -> Result:
    """Do a job in this process; a scenario that cannot be built or run is a result too."""
    begin = time.perf_counter()
    blank = Result(
        job.role.report, job.role.number, job.policy, reproduced=False if job.task is Task.REPRODUCE else None
    )
    try:
        done = _WORK[job.task](job, blank)
    except RoadmendError as error:
        done = replace(blank, text=str(error))
    except Exception as error:  # noqa: BLE001 - a fault of ours must not end the work on all other reports
        done = replace(blank, text=" ".join(f"{type(error).__name__}: {error}".split()))
    return replace(done, seconds=done.seconds or time.perf_counter() - begin)


def _build(job: Job, blank: Result) -> Result:
    scenario = draw_scenario(job.role, job.index, job.seed)
    with Simulation(scenario) as simulation:
        simulation.first()
    return replace(blank, scenario=_save(job, scenario), text="built")


def _test(job: Job, blank: Result) -> Result:
    begin = time.perf_counter()
    scenario = draw_scenario(job.role, job.index, job.seed)
    trial = run_trial(scenario, job.policy)
    seconds = time.perf_counter() - begin
    return replace(_driven(job, blank, scenario, trial), episodes=1, seconds=seconds)


def _reproduce(job: Job, blank: Result) -> Result:
    begin = time.perf_counter()
    found = reproduce(job.role, job.policy, job.budget, job.seed)
    seconds = time.perf_counter() - begin
    done = replace(blank, text=found.outcome, episodes=found.episodes, seconds=seconds)
    if found.scenario is None or found.trial is None:
        return done
    return replace(_driven(job, done, found.scenario, found.trial), reproduced=True)


_WORK: dict[Task, Callable[[Job, Result], Result]] = {
    Task.BUILD: _build,
    Task.TEST: _test,
    Task.REPRODUCE: _reproduce,
}


def _driven(job: Job, blank: Result, scenario: Scenario, trial: Trial) -> Result:
    """The result of an episode, its scenario and picture written."""
    picture = ""
    if job.draw is not None:
        picture = f"{PICTURES}/{scenario.name}-{job.policy}.png"
        job.draw(scenario, trial, job.out / picture)
    return replace(
        blank,
        scenario=_save(job, scenario),
        picture=picture,
        outcome=trial.summary.outcome.name,
        text=trial.summary.text,
        collision=trial.is_collision,
        at_fault=trial.is_at_fault,
    )


def _save(job: Job, scenario: Scenario) -> str:
    file = f"{SCENARIOS}/{scenario.name}.yaml"
    save_scenario(scenario, job.out / file)
    return file
