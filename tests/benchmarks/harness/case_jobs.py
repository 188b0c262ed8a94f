"""The benchmark's work, piece by piece: cases under methods, and monitors beside the policy alone."""

import hashlib
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from harness.contenders import Contender
from roadmend.core.command import Decision
from roadmend.core.errors import SimulationError
from roadmend.core.fanout import fan_out
from roadmend.core.interfaces import Repairer
from roadmend.core.repair import Repair
from roadmend.core.route import Route
from roadmend.core.scene import Scene
from roadmend.core.tick import Tick
from roadmend.measures.answering import Answering
from roadmend.measures.case_result import CaseResult
from roadmend.measures.evaluation import seed_of
from roadmend.measures.monitor import Confusion
from roadmend.policies.registry import make_policy
from roadmend.repair.registry import make_repairer
from roadmend.world.corpus import Case
from roadmend.world.runner import run_episode

Floats = NDArray[np.float64]


class CriticalFrames(Protocol):
    """Says which frames of an episode are critical; travels to other processes by pickle."""

    def __call__(self, case: Case, time: Floats, distance: Floats, end: float, outcome: str, /) -> NDArray[np.bool_]:
        """Labels of shape (T,).

        Args:
            case: what was driven.
            time: [s] of every decision, shape (T,).
            distance: [m] between the ego's outline and the nearest other, infinite where there is none, shape (T,).
            end: [s] when the episode was over.
            outcome: an EventKind's name.
        """


def case_key(case: Case) -> str:
    """Digest of what decides how a case runs, and of what it is called."""
    content = [case.name, case.family, case.seed, dict(case.parameters), case.is_violation]
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


@dataclass(frozen=True, slots=True)
class CaseJob:
    """A piece of work: one episode."""

    case: Case
    contenders: tuple[Contender, ...]  # the one that repairs, or all that watch
    keys: tuple[str, ...]  # of the results, one a contender
    labels: CriticalFrames | None = None  # with it the contenders are watched as monitors, and nobody repairs
    repairer: Repairer | None = None  # repairs instead of the contender, which only lends its name


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a job came to: its results as plain values, or why there are none."""

    job: CaseJob
    results: tuple[dict[str, Any], ...] = ()
    fault: str = ""


class Onlookers:
    """A repairer that never steps in, and lets others judge every scene beside it."""

    name = "onlookers"

    def __init__(self, monitors: Sequence[Repairer], alone: Repairer) -> None:
        self._monitors = monitors
        self._alone = alone
        self.alarms: list[list[bool]] = [[] for _ in monitors]

    def reset(self, route: Route) -> None:
        """Begin an episode on ``route``."""
        for repairer in (*self._monitors, self._alone):
            repairer.reset(route)

    def step(self, scene: Scene, decision: Decision) -> Repair:
        """Ask everybody, pass the policy's command through."""
        for monitor, alarms in zip(self._monitors, self.alarms, strict=True):
            repair = monitor.step(scene, decision)
            alarms.append(repair.score > repair.threshold)
        return self._alone.step(scene, decision)


def run_job(job: CaseJob) -> Outcome:
    """Do one piece of work in this process; whatever goes wrong is a result here."""
    try:
        results = _repair(job) if job.labels is None else _monitor(job, job.labels)
    except Exception as error:  # noqa: BLE001 - the others shall go on, and this one is reported
        names = ", ".join(contender.name for contender in job.contenders)
        policy = job.contenders[0].policy
        text = " ".join(f"{type(error).__name__}: {error}".split())
        return Outcome(job, fault=f"{job.case.name}, policy {policy}, {names}: {text}")
    return Outcome(job, results)


def _repair(job: CaseJob) -> tuple[dict[str, Any], ...]:
    case, (contender,) = job.case, job.contenders
    repairer = job.repairer or _method(contender, case)
    episode = run_episode(case.scenario(), make_policy(contender.policy), repairer)
    if not episode.is_finite:
        raise SimulationError("a pose or a command was not a number")
    return (CaseResult(case.name, case.family, case.is_violation, episode).dump(),)


def _method(contender: Contender, case: Case) -> Repairer:
    return Answering(make_repairer(contender.method, contender.parameters, seed_of(case.name)))


def _monitor(job: CaseJob, labels: CriticalFrames) -> tuple[dict[str, Any], ...]:
    case = job.case
    onlookers = Onlookers([_method(each, case) for each in job.contenders], make_repairer("none"))
    times: list[float] = []
    distances: list[float] = []

    def watch(tick: Tick, _decision: Decision, _repair: Repair) -> None:
        times.append(tick.scene.time)
        distances.append(tick.min_distance)

    summary = run_episode(case.scenario(), make_policy(job.contenders[0].policy), onlookers, watch)
    critical = labels(case, np.array(times), np.array(distances), summary.duration, summary.outcome.name)
    return tuple(Confusion.of(critical, np.array(alarms, dtype=np.bool_)).dump() for alarms in onlookers.alarms)


def run_jobs(jobs: Sequence[CaseJob], workers: int) -> Iterator[Outcome]:
    """Do all the work, side by side; what comes out, in the order of the jobs, does not depend on the number of workers.

    Raises:
        SimulationError: a worker process died.
    """
    with fan_out(workers, len(jobs)) as mapper:
        yield from mapper(run_job, jobs)
