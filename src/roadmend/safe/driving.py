"""What is done with crash reports, cut into jobs: one scenario to build or to drive, or one crash to reproduce."""

import hashlib
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from pathlib import Path

from roadmend.core.episode_result import EpisodeResult
from roadmend.core.errors import InputError, RoadmendError
from roadmend.core.journal import Key, entry_key
from roadmend.measures.driver import driver_key
from roadmend.safe.construction import CrashRole, draw_scenario, plain_name
from roadmend.safe.reproduction import reproduce
from roadmend.safe.trial import CrashTestEpisode, run_trial
from roadmend.world.scenario import Scenario
from roadmend.world.scenario_file import save_scenario
from roadmend.world.simulation import Simulation

SCENARIOS = "scenarios"  # folders in the output
PICTURES = "pictures"

Drawing = Callable[
    [Scenario, CrashTestEpisode, Path], None
]  # draws an episode into a file; a function that a worker can import


class Task(StrEnum):
    """What a job does with a role of a report."""

    BUILD = "build"
    TEST = "test"
    REPRODUCE = "reproduce"


@dataclass(frozen=True, slots=True)
class CrashTestJob:
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
    role: CrashRole
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
class CrashTestResult:
    """What a job came to.

    Attributes:
        report: name of the report.
        vehicle: number of the vehicle whose place the ego took; None where it looked on.
        policy: name.
        scenario: file in the output folder; empty if none was built (test) or nothing reproduced.
        picture: file in the output folder, or empty.
        driven: what the episode came to; None if nothing ran.
        note: why it did not run, or what a reproduction came to.
        reproduced: whether it was the crash as this program's own reading of the report has it; None for a test. The
            independent judge is another one, see ``judging``.
        physical: whether everybody moved as vehicles can; None if nothing ran.
        episodes: that were driven.
        seconds: wall clock, building and driving.
        digests: of these files as they were written, by file; another seed or budget gives others of the same names.
        failed: whether an error ended it. What is full or away may not be so later, so such a result is not kept.
    """

    report: str
    vehicle: int | None
    policy: str
    scenario: str = ""
    picture: str = ""
    driven: EpisodeResult | None = None
    note: str = ""
    reproduced: bool | None = None
    physical: bool | None = None
    episodes: int = 0
    seconds: float = 0.0
    digests: Mapping[str, str] = field(default_factory=dict)
    failed: bool = False

    @property
    def text(self) -> str:
        """How the episode ended, and what of the crash it lacks; the note alone where there was none."""
        if self.driven is None:
            return self.note
        lacks = self.reproduced is False and self.note and self.note != self.driven.text
        return f"{self.driven.text}; not as described: {self.note}" if lacks else self.driven.text


def do(job: CrashTestJob) -> CrashTestResult:
    """Do a job in this process; a scenario that cannot be built or run is a result too.

    Raises:
        InputError: the folder cannot be written.
    """
    begin = time.perf_counter()
    blank = CrashTestResult(
        job.role.report, job.role.number, job.policy, reproduced=False if job.task is Task.REPRODUCE else None
    )
    try:
        done = _done(job, blank)
    except InputError:  # of the folder: what ends every other job too is no result of this one
        raise
    except Exception as error:  # noqa: BLE001 - a fault of ours must not end the work on all other reports
        done = replace(blank, note=" ".join(f"{type(error).__name__}: {error}".split()), failed=True)
    return replace(done, seconds=done.seconds or time.perf_counter() - begin)


def _done(job: CrashTestJob, blank: CrashTestResult) -> CrashTestResult:
    """The result with its files written; only that raises an InputError."""
    try:
        done, scenario, trial = _WORK[job.task](job, blank)
    except RoadmendError as error:
        return replace(blank, note=str(error), failed=True)
    if scenario is None:
        return done
    picture = ""
    if job.draw is not None and trial is not None:
        picture = f"{PICTURES}/{scenario.name}-{plain_name(job.policy)}.png"
        job.draw(scenario, trial, job.out / picture)
    file = f"{SCENARIOS}/{scenario.name}.yaml"
    save_scenario(scenario, job.out / file)
    digests = {each: digest_of(job.out / each) for each in (file, picture) if each}
    return replace(done, scenario=file, picture=picture, digests=digests)


def digest_of(file: Path) -> str:
    """SHA-256 of a file's content, hexadecimal; empty where there is none to read."""
    try:
        return hashlib.sha256(file.read_bytes()).hexdigest()
    except OSError:
        return ""


_Made = tuple[CrashTestResult, Scenario | None, CrashTestEpisode | None]  # the last two are to be written


def _build(job: CrashTestJob, blank: CrashTestResult) -> _Made:
    scenario = draw_scenario(job.role, job.index, job.seed)
    with Simulation(scenario) as simulation:
        simulation.first()
    return replace(blank, note="built"), scenario, None


def _test(job: CrashTestJob, blank: CrashTestResult) -> _Made:
    begin = time.perf_counter()
    scenario = draw_scenario(job.role, job.index, job.seed)
    trial = run_trial(scenario, job.policy)
    seconds = time.perf_counter() - begin
    return replace(_driven(blank, trial), episodes=1, seconds=seconds), scenario, trial


def _reproduce(job: CrashTestJob, blank: CrashTestResult) -> _Made:
    begin = time.perf_counter()
    found = reproduce(job.role, job.policy, job.budget, job.seed)
    seconds = time.perf_counter() - begin
    done = replace(blank, note=found.outcome, episodes=found.episodes, seconds=seconds)
    if found.scenario is None or found.trial is None:
        return done, None, None
    is_own = found.own is not None and found.own.is_reproduced
    return replace(_driven(done, found.trial), reproduced=is_own), found.scenario, found.trial


_WORK: dict[Task, Callable[[CrashTestJob, CrashTestResult], _Made]] = {
    Task.BUILD: _build,
    Task.TEST: _test,
    Task.REPRODUCE: _reproduce,
}


def _driven(blank: CrashTestResult, trial: CrashTestEpisode) -> CrashTestResult:
    """The result of an episode."""
    return replace(blank, driven=trial.summary, physical=trial.is_physical)
