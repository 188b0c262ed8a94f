"""Runs the benchmark of repair methods: what is missing in the journal is driven, the rest is read from it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from harness.case_jobs import CaseJob, CriticalFrames, case_key, run_job, run_jobs
from harness.contenders import Absence, Contender
from roadmend.core.errors import RoadmendError
from roadmend.core.interfaces import Repairer
from roadmend.core.journal import Journal, Key, entry_key
from roadmend.measures.case_result import CaseResult
from roadmend.measures.monitor import Confusion
from roadmend.world.corpus import Case

RESULTS = "results.jsonl"  # in the folder for work
FORMAT = "roadmend-benchmark-work/2"
HINDSIGHT = "hindsight"  # the bound that all methods are held against


@dataclass(frozen=True, slots=True)
class Player:
    """Plays what a search in hindsight has found for one case."""

    repairer: Repairer
    digest: str  # of what it plays


@dataclass(frozen=True, slots=True)
class PolicyBenchmark:
    """All that one policy is measured with."""

    policy: str
    policy_digest: str  # of its model, empty without one
    corpus_digest: str
    cases: tuple[Case, ...]
    contenders: tuple[Contender, ...]
    monitors: tuple[Contender, ...]
    absences: tuple[Absence, ...]
    players: Mapping[str, Mapping[str, Player]] = field(default_factory=dict)  # of contenders that are bounds; by case


@dataclass(frozen=True, slots=True)
class Measured:
    """What one policy came to."""

    benchmark: PolicyBenchmark
    results: dict[str, tuple[CaseResult, ...]]  # by method, in the order of the cases
    confusions: dict[str, tuple[Confusion, ...]]  # by monitor, in the order of the cases

    @property
    def unreproduced(self) -> tuple[str, ...]:
        """Cases that the policy alone does not drive as its corpus says; empty where it was not run alone."""
        alone = self.results.get("none", ())
        pairs = zip(self.benchmark.cases, alone, strict=False)
        return tuple(case.name for case, result in pairs if case.digest != result.episode.digest)


def find_jobs(benchmark: PolicyBenchmark, journal: Journal, labels: CriticalFrames) -> list[CaseJob]:
    """What is still to be done for one policy."""
    jobs = []
    for contender in benchmark.contenders:
        for case in benchmark.cases:
            key = _repair_key(benchmark, contender, case)
            if journal.get(key) is None:
                player = _player(benchmark, contender, case)
                jobs.append(CaseJob(case, (contender,), (key,), repairer=player.repairer if player else None))
    for case in benchmark.cases:
        keys = {_monitor_key(benchmark, monitor, case, labels): monitor for monitor in benchmark.monitors}
        missing = [key for key in keys if journal.get(key) is None]
        if missing:
            jobs.append(CaseJob(case, tuple(keys[key] for key in missing), tuple(missing), labels))
    return jobs


def drive(
    jobs: Sequence[CaseJob], journal: Journal, workers: int, report: Callable[[CaseJob], None] = lambda _job: None
) -> None:
    """Do the work and keep its results.

    Raises:
        RoadmendError: some of it failed; all the rest was done and kept.
        InputError: the store cannot be written.
    """
    faults = []
    for outcome in run_jobs(jobs, workers):
        for key, result in zip(outcome.job.keys, outcome.results, strict=False):
            journal.add(key, result)
        if outcome.fault:
            faults.append(outcome.fault)
        report(outcome.job)
    if faults:
        raise RoadmendError(f"{len(faults)} of {len(jobs)} episodes failed; the first: {min(faults)}")


def read_results(benchmark: PolicyBenchmark, journal: Journal, labels: CriticalFrames) -> Measured:
    """The results of one policy after all of its jobs are done."""
    results = {
        contender.name: tuple(
            CaseResult.parse(_done(journal, _repair_key(benchmark, contender, case))) for case in benchmark.cases
        )
        for contender in benchmark.contenders
    }
    confusions = {
        monitor.name: tuple(
            Confusion(**_done(journal, _monitor_key(benchmark, monitor, case, labels))) for case in benchmark.cases
        )
        for monitor in benchmark.monitors
    }
    return Measured(benchmark, results, confusions)


def _player(benchmark: PolicyBenchmark, contender: Contender, case: Case) -> Player | None:
    return benchmark.players[contender.name][case.name] if contender.group == "bound" else None


def _repair_key(benchmark: PolicyBenchmark, contender: Contender, case: Case) -> Key:
    player = _player(benchmark, contender, case)
    played = player.digest if player is not None else ""
    return entry_key(
        [run_job.__module__], "repair", benchmark.policy, benchmark.policy_digest, contender.key, played, case_key(case)
    )


def _monitor_key(benchmark: PolicyBenchmark, monitor: Contender, case: Case, labels: CriticalFrames) -> Key:
    code = [run_job.__module__, labels.__module__]
    return entry_key(code, "monitor", benchmark.policy, benchmark.policy_digest, monitor.key, case_key(case))


def _done(journal: Journal, key: Key) -> dict[str, Any]:
    result = journal.get(key)
    if result is None:
        raise RoadmendError("a result is missing; run the same command again to go on")
    return result
