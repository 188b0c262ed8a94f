"""``roadmend sera evaluate``: how a policy fares on an evaluation set, with bags of what went wrong."""

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, cast

import click

from roadmend.cli.options import WORKERS
from roadmend.cli.output import counting, show_rows
from roadmend.cli.sera_options import set_options
from roadmend.core.errors import InputError
from roadmend.core.fanout import fan_out
from roadmend.core.journal import Journal
from roadmend.measures.driver import driver_key
from roadmend.measures.driving import DrivingMeasures
from roadmend.measures.summary import summarise, summary_rows
from roadmend.policies.registry import POLICIES
from roadmend.repair.registry import METHODS
from roadmend.reports.result_files import provenance, write_report
from roadmend.sera.evaluation_episode import EvaluatedEpisode, EvaluationJob, Record
from roadmend.sera.evaluation_episode import evaluate as drive
from roadmend.sera.evaluation_set import corpus_set, disjoint, known_in, sampled_set
from roadmend.world.scenario import Scenario

_BAGS = "bags"
_NAME = "measures"
_FORMAT = "roadmend-evaluated-episodes/1"


@click.command()
@click.option(
    "--policy",
    default="modular",
    show_default=True,
    help=f"One of {', '.join(sorted(POLICIES))}, or the model file of a neural policy.",
)
@click.option("--repair", "method", default="none", show_default=True, type=click.Choice(sorted(METHODS)))
@set_options
@click.option(
    "--disjoint-from",
    "known",
    multiple=True,
    type=click.Path(path_type=Path, dir_okay=False),
    help="A bank, a corpus or a scenario file: what is in it is left out. May be repeated.",
)
@click.option(
    "--record",
    default="failures",
    show_default=True,
    type=click.Choice(["failures", "all", "none"]),
    help="Bags; failures: of what does not end at the goal or is repaired on the way.",
)
@WORKERS
@click.option("--out", required=True, type=click.Path(path_type=Path, file_okay=False), help="Folder; resumes there.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def evaluate(
    policy: str,
    method: str,
    scenarios: int | None,
    first_seed: int | None,
    corpus: Path | None,
    split: str | None,
    known: tuple[Path, ...],
    record: str,
    workers: int,
    out: Path,
    *,
    as_json: bool,
) -> int:
    """Drive a policy through an evaluation set in this process: four measures, and bags for 'sera analyse'.

    An interrupted call goes on where it stopped; the outcome does not depend on the number of workers. The exit code is
    1 if an episode could not be driven.
    """
    whole = chosen_set(scenarios, first_seed, corpus, split)
    chosen = disjoint(whole, known_in(known))
    driver = driver_key(policy, method)
    jobs = [EvaluationJob(one, policy, method, out / _BAGS, cast(Record, record), driver) for one in chosen]
    with counting(is_transient=True) as progress:
        task = progress.add_task("episodes", total=len(jobs))
        found = drive_jobs(jobs, out, workers, lambda done, _: progress.update(task, completed=done))
    content = _content(jobs, found, len(whole) - len(chosen))
    families = {one.family or "other" for one in chosen}
    measures = {name: _measures(jobs, found, name) for name in [*sorted(families), "all"]}
    content["summary"] = summarise(measures["all"])
    content["families"] = {name: summarise(measures[name]) for name in sorted(families)}
    rows = summary_rows({**content["families"], "all": content["summary"]})
    write_report(out, _NAME, f"{policy} with repair {method}", content, rows)
    if as_json:
        click.echo(json.dumps(content, indent=2))
    else:
        _show(rows, content)
    for fault in content["faults"]:
        click.echo(fault, err=True)
    return 1 if content["faults"] else 0


def chosen_set(scenarios: int | None, first_seed: int | None, corpus: Path | None, split: str | None) -> list[Scenario]:
    """The evaluation set that the options stand for.

    Raises:
        InputError: they contradict each other, or the file is no corpus.
    """
    if corpus is None:
        if split is not None:
            raise InputError("--split", "is of a corpus, and there is none", "name one with --corpus")
        return sampled_set(20 if scenarios is None else scenarios, first_seed or 0)
    if scenarios is not None or first_seed is not None:
        raise InputError("--corpus", "leaves nothing to draw", "give either --corpus or --scenarios and --first-seed")
    return corpus_set(corpus, split)


def drive_jobs(
    jobs: Sequence[EvaluationJob], out: Path, workers: int, told: Callable[[int, int], None]
) -> list[EvaluatedEpisode]:
    """What each job came to, in order; what is there from an earlier call is not driven again.

    Args:
        jobs: to do.
        out: folder of what was done.
        workers: processes.
        told: hears how many are done, of how many.

    Raises:
        InputError: the folder holds something else, or cannot be written.
        SimulationError: a worker process died.
    """
    with Journal(out / "results.jsonl", _FORMAT, owns_folder=True) as journal:
        done = {job.key: _parse(kept) for job in jobs if (kept := journal.get(job.key)) is not None}
        missing = [job for job in jobs if job.key not in done]
        before = len(jobs) - len(missing)
        told(before, len(jobs))
        with fan_out(workers, len(missing)) as mapper:
            for number, (job, episode) in enumerate(zip(missing, mapper(drive, missing), strict=True), before + 1):
                done[job.key] = episode
                if not episode.fault:
                    journal.add(job.key, asdict(episode))
                told(number, len(jobs))
    return [done[job.key] for job in jobs]


def _parse(kept: dict[str, Any]) -> EvaluatedEpisode:
    measures = dict(kept["measures"])
    measures["infractions"] = tuple(measures["infractions"])
    return EvaluatedEpisode(DrivingMeasures(**measures), kept["trajectory"], kept["bag"])


def _content(jobs: Sequence[EvaluationJob], found: Sequence[EvaluatedEpisode], left_out: int) -> dict[str, Any]:
    first = jobs[0]
    episodes = [
        {"scenario": job.scenario.name, "family": job.scenario.family, "digest": job.scenario.digest, **asdict(episode)}
        for job, episode in zip(jobs, found, strict=True)
        if not episode.fault
    ]
    return {
        "provenance": provenance(f"./roadmend sera evaluate --policy {first.policy} --repair {first.method}"),
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


def _show(rows: Sequence[Sequence[str]], content: dict[str, Any]) -> None:
    show_rows(rows)
    bags = sum(bool(episode["bag"]) for episode in content["episodes"])
    left = content["left_out"]
    click.echo(f"{bags} bag{'' if bags == 1 else 's'}" + (f"; {left} known scenarios left out" if left else ""))
