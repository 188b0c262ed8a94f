"""Judging what a search came to: each found scenario is driven once more from its file and held against records.

What is judged is the file and the record of the real crash, nothing else: whoever has both can do it again. The record
of another crash on the same type of road shows how easily the judge is pleased.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from roadmend.core.errors import RoadmendError
from roadmend.core.fanout import fan_out
from roadmend.safe.crash_record import CrashRecord
from roadmend.safe.driving import CrashTestResult
from roadmend.safe.judge import judge
from roadmend.safe.likeness import Likeness
from roadmend.safe.trial import run_trial
from roadmend.world.scenario_file import load_scenario


@dataclass(frozen=True, slots=True)
class JudgedRun:
    """What the judge says of one role of a report.

    Attributes:
        report: name.
        vehicle: number of the vehicle whose place the ego took; None where it looked on.
        policy: name.
        failed: what differs, by dimension; None where there is nothing to judge.
        note: why there is nothing.
        shown: collisions of the record that the run shows.
        recorded: collisions that the record has: of two vehicles, or those of a vehicle that crashed alone.
        is_physical: whether everybody moved as vehicles can; None where nothing ran.
        hardest: largest accelerations along and across the way [m/s2] of all in the run.
        wrong_records: records of other crashes on the same type of road.
        wrongly_accepted: those of them that the run would reproduce.
        stood: whether the record has the ego's vehicle standing.
    """

    report: str
    vehicle: int | None
    policy: str
    failed: Mapping[str, str] | None = None
    note: str = ""
    shown: int = 0
    recorded: int = 0
    is_physical: bool | None = None
    hardest: tuple[float, float] = (0.0, 0.0)
    wrong_records: int = 0
    wrongly_accepted: int = 0
    stood: bool = False

    @property
    def is_reproduced(self) -> bool:
        """Whether it is the crash of the record."""
        return self.failed is not None and not self.failed


@dataclass(frozen=True, slots=True)
class _JudgingJob:
    result: CrashTestResult
    out: Path
    record: CrashRecord | None
    wrong: tuple[CrashRecord, ...] = field(default=())


def judge_results(
    results: Sequence[CrashTestResult],
    records: Mapping[str, CrashRecord],
    out: Path,
    workers: int,
    told: Callable[[int], None],
) -> list[JudgedRun]:
    """Judge every result of a search, in its order.

    Args:
        results: of the task to reproduce.
        records: by the report's name.
        out: folder that the results' scenarios are in.
        workers: processes.
        told: hears how many are done.

    Raises:
        SimulationError: a worker process died.
    """
    jobs = [_JudgingJob(each, out, records.get(each.report), _others(each.report, records)) for each in results]
    judged = []
    with fan_out(workers, len(jobs)) as mapper:
        for number, run in enumerate(mapper(_judge, jobs), 1):
            judged.append(run)
            told(number)
    return judged


def _others(report: str, records: Mapping[str, CrashRecord]) -> tuple[CrashRecord, ...]:
    """The records of other crashes on the same type of road: of vehicles alone for one alone, of several for several.

    That the one kind is never taken for the other is how the judge is made; such pairs would only swell the count.
    """
    own = records.get(report)
    if own is None:
        return ()
    return tuple(
        each
        for name, each in sorted(records.items())
        if name != report
        and (each.is_alone if own.is_alone else bool(each.collisions))
        and {*each.roads} & {*own.roads}
    )


def _judge(job: _JudgingJob) -> JudgedRun:
    result, record = job.result, job.record
    blank = JudgedRun(result.report, result.vehicle, result.policy, note=result.note)
    if not result.scenario:
        return blank
    if record is None:
        return JudgedRun(result.report, result.vehicle, result.policy, note="there is no record of this crash")
    try:
        trial = run_trial(load_scenario(job.out / result.scenario), result.policy)
    except RoadmendError as error:
        return JudgedRun(result.report, result.vehicle, result.policy, note=str(error))
    found = judge(trial.run, record)
    motions = trial.run.motions.values()
    return JudgedRun(
        result.report,
        result.vehicle,
        result.policy,
        {dimension.value: reason for dimension, reason in found.failed.items()},
        "; ".join(found.failed.values()),
        found.shown,
        found.recorded,
        trial.is_physical,
        (
            round(max((motion.longitudinal for motion in motions), default=0.0), 2),
            round(max((motion.lateral for motion in motions), default=0.0), 2),
        ),
        len(job.wrong),
        sum(judge(trial.run, each).is_reproduced for each in job.wrong),
        result.vehicle is not None and record.vehicle(result.vehicle).stands,
    )


@dataclass(frozen=True, slots=True)
class JudgedSummary:
    """What the judge says of many reports.

    Attributes:
        reports: all, also those that cannot be played or have no record.
        recorded: those with a record.
        run: those of which a run exists.
        reproduced: those of which the judge takes at least one role's run for the crash.
        stood: those of the reproduced ones in which the policy only played vehicles that stood.
        looked_on: those in which it played none: a vehicle crashed alone before its eyes.
        names: of the reproduced ones.
        but_for: how many there would be were one dimension dropped.
        failed: how many runs differ, by dimension.
        unphysical: runs in which somebody moved as no vehicle can.
        shown: collisions that the reproducing runs show.
        collisions: that the records of these crashes have.
        wrong_records: pairs of a run and the record of another crash on the same type of road.
        wrongly_accepted: those of them that the judge takes for that crash.
    """

    reports: int
    recorded: int
    run: int
    reproduced: int
    stood: int
    looked_on: int
    names: tuple[str, ...]
    but_for: Mapping[str, int]
    failed: Mapping[str, int]
    unphysical: int
    shown: int
    collisions: int
    wrong_records: int
    wrongly_accepted: int


def summarise_judged(reports: Sequence[str], recorded: Sequence[str], runs: Sequence[JudgedRun]) -> JudgedSummary:
    """Count what the judge says of one policy's runs."""
    judged = [run for run in runs if run.failed is not None]
    names = sorted({run.report for run in judged if run.is_reproduced})
    played = {run.report for run in judged if run.is_reproduced and not run.stood}

    def but_for(dropped: Likeness) -> int:
        return len({run.report for run in judged if not {*(run.failed or ())} - {dropped.value}})

    best: dict[str, JudgedRun] = {}
    for run in judged:
        if run.is_reproduced and (run.report not in best or run.shown > best[run.report].shown):
            best[run.report] = run
    return JudgedSummary(
        reports=len(reports),
        recorded=sum(report in {*recorded} for report in reports),
        run=len({run.report for run in judged}),
        reproduced=len(names),
        stood=len({*names} - played),
        looked_on=len({run.report for run in judged if run.is_reproduced and run.vehicle is None}),
        names=tuple(names),
        but_for={dimension.value: but_for(dimension) for dimension in Likeness},
        failed={
            dimension.value: sum(dimension.value in (run.failed or ()) for run in judged) for dimension in Likeness
        },
        unphysical=sum(run.is_physical is False for run in runs),
        shown=sum(run.shown for run in best.values()),
        collisions=sum(run.recorded for run in best.values()),
        wrong_records=sum(run.wrong_records for run in judged),
        wrongly_accepted=sum(run.wrongly_accepted for run in judged),
    )
