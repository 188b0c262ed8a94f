"""``roadmend sera evaluate``: how a policy fares on an evaluation set, and bags of what went wrong."""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any, cast

import click

from roadmend.cli.call import call_again
from roadmend.cli.command import ExampleCommand
from roadmend.cli.driver_options import POLICY, REPAIR
from roadmend.cli.options import FILE, JSON, RESULT_FOLDER, WORKERS, options_of
from roadmend.cli.output import counting, show_rows
from roadmend.cli.sera_options import SetChoice, set_options
from roadmend.measures.driver import driver_key
from roadmend.measures.driving import DrivingMeasures
from roadmend.measures.fitting import fitting
from roadmend.measures.summary import summarise, summary_rows
from roadmend.reports.result_files import provenance, write_report
from roadmend.sera.evaluation_episode import EvaluatedEpisode, EvaluationJob, Record, drive_jobs
from roadmend.sera.evaluation_set import disjoint, known_in

_BAGS = "bags"
_NAME = "measures"


@dataclass(frozen=True)
class EvaluateOptions:
    """Who drives, on what, and what is recorded."""

    policy: Annotated[str, POLICY]
    method: Annotated[str, REPAIR]
    chosen: Annotated[SetChoice, set_options]
    known: Annotated[
        tuple[Path, ...],
        click.option(
            "--disjoint-from",
            "known",
            multiple=True,
            type=FILE,
            help="A bank, a corpus or a scenario file: what is in it is left out. May be repeated.",
        ),
    ]
    record: Annotated[
        str,
        click.option(
            "--record",
            default="failures",
            show_default=True,
            type=click.Choice(["failures", "all", "none"]),
            help="Bags; failures: of what does not end at the goal or is repaired on the way.",
        ),
    ]
    workers: Annotated[int, WORKERS]
    out: Annotated[Path, RESULT_FOLDER]
    as_json: Annotated[bool, JSON]


@click.command(
    cls=ExampleCommand, examples=["roadmend sera evaluate --policy neural --scenarios 20 --out evaluated"], resumes=""
)
@options_of(EvaluateOptions)
def evaluate(given: EvaluateOptions) -> int:
    """Drive a policy through an evaluation set in this process: four measures, and bags for 'sera analyse'.

    An interrupted call goes on where it stopped; the outcome does not depend on the number of workers. The exit code is
    1 if an episode could not be driven.
    """
    whole = given.chosen.read()
    chosen = disjoint(whole, known_in(given.known))
    driver = driver_key(given.policy, given.method, fitting(given.method, given.policy))
    jobs = [
        EvaluationJob(one, given.policy, given.method, given.out / _BAGS, cast(Record, given.record), driver)
        for one in chosen
    ]
    with counting(is_transient=True) as progress:
        task = progress.add_task("episodes", total=len(jobs))
        found = drive_jobs(jobs, given.out, given.workers, lambda done, _: progress.update(task, completed=done))
    content = _measured(jobs, found, len(whole) - len(chosen))
    families = {one.family or "other" for one in chosen}
    measures = {name: _measures(jobs, found, name) for name in [*sorted(families), "all"]}
    content["summary"] = summarise(measures["all"])
    content["families"] = {name: summarise(measures[name]) for name in sorted(families)}
    rows = summary_rows({**content["families"], "all": content["summary"]})
    write_report(given.out, _NAME, f"{given.policy} with repair {given.method}", content, rows)
    if given.as_json:
        click.echo(json.dumps(content, indent=2))
    else:
        _show_measures(rows, content)
    for fault in content["faults"]:
        click.echo(fault, err=True)
    return 1 if content["faults"] else 0


def _measured(jobs: Sequence[EvaluationJob], found: Sequence[EvaluatedEpisode], left_out: int) -> dict[str, Any]:
    first = jobs[0]
    episodes = [
        {
            "scenario": job.scenario.name,
            "family": job.scenario.family,
            "digest": job.scenario.digest,
            "measures": asdict(episode.measures),
            "trajectory": episode.result.digest,
            "bag": episode.bag,
            "fault": "",
        }
        for job, episode in zip(jobs, found, strict=True)
        if episode.result is not None and episode.measures is not None
    ]
    return {
        "provenance": provenance(call_again(always=("policy", "method"))),
        "policy": first.policy,
        "method": first.method,
        "left_out": left_out,
        "faults": [episode.fault for episode in found if episode.fault],
        "episodes": episodes,
    }


def _measures(jobs: Sequence[EvaluationJob], found: Sequence[EvaluatedEpisode], family: str) -> list[DrivingMeasures]:
    return [
        episode.measures
        for job, episode in zip(jobs, found, strict=True)
        if episode.measures is not None and family in {"all", job.scenario.family or "other"}
    ]


def _show_measures(rows: Sequence[Sequence[str]], content: dict[str, Any]) -> None:
    show_rows(rows)
    bags = sum(bool(episode["bag"]) for episode in content["episodes"])
    left = content["left_out"]
    click.echo(f"{bags} bag{'' if bags == 1 else 's'}" + (f"; {left} known scenarios left out" if left else ""))
