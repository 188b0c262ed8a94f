"""``roadmend bench outcomes``: how a policy fares in random scenarios, and that runs repeat bit for bit."""

from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

from harness.figures import Figures
from roadmend.cli.options import WORKERS
from roadmend.cli.output import counting
from roadmend.core.episode_result import EpisodeResult
from roadmend.core.fanout import fan_out
from roadmend.core.outcome import EventKind
from roadmend.measures.answering import Answering
from roadmend.measures.intervals import wilson
from roadmend.policies.registry import POLICIES, make_policy
from roadmend.repair.registry import METHODS, make_repairer
from roadmend.reports.result_files import provenance
from roadmend.world.families import FAMILIES, sample_scenario
from roadmend.world.runner import run_episode

_OUTCOMES = (EventKind.GOAL, EventKind.COLLISION, EventKind.TIMEOUT, EventKind.OFF_ROUTE)


@dataclass(frozen=True)
class _Job:
    family: str
    seed: int
    policy: str
    method: str
    repeat: bool


@dataclass(frozen=True)
class _Report:
    family: str
    seed: int
    outcome: str
    digest: str
    fault: str  # empty if the run was sound
    interventions: int
    ticks: int


def _finite(summary: EpisodeResult) -> bool:
    return summary.is_finite


def _work(job: _Job) -> _Report:
    try:
        first = _episode(job)
        fault = "" if _finite(first) else "not a number"
        if job.repeat and _episode(job).digest != first.digest:
            fault = "the repeated run differs"
    except Exception as error:  # noqa: BLE001 - a crash is a result here
        return _Report(job.family, job.seed, "CRASH", "", f"{type(error).__name__}: {error}", 0, 0)
    return _Report(job.family, job.seed, first.outcome.name, first.digest, fault, first.interventions, first.ticks)


def _episode(job: _Job) -> EpisodeResult:
    scenario = sample_scenario(job.family, job.seed)
    return run_episode(scenario, make_policy(job.policy), Answering(make_repairer(job.method)))


@click.command()
@click.option("--policy", default="modular", show_default=True, type=click.Choice(sorted(POLICIES)))
@click.option("--repair", "method", default="none", show_default=True, type=click.Choice(sorted(METHODS)))
@click.option(
    "--scenarios", default=200, show_default=True, type=click.IntRange(1, 100_000), help="Scenarios of each family."
)
@click.option("--first-seed", default=0, show_default=True, type=click.IntRange(0, 2**30))
@click.option("--repeat/--no-repeat", default=True, show_default=True, help="Run each twice and compare the digests.")
@WORKERS
@click.option(
    "--out", type=click.Path(path_type=Path, file_okay=False), help="Folder for outcomes.json and outcomes.md."
)
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def outcomes(
    policy: str,
    method: str,
    scenarios: int,
    first_seed: int,
    workers: int,
    out: Path | None,
    *,
    repeat: bool,
    as_json: bool,
) -> int:
    """Run random scenarios of every family; exit code 1 if a run crashes, yields NaN or does not repeat."""
    jobs = [
        _Job(family, first_seed + number, policy, method, repeat) for family in FAMILIES for number in range(scenarios)
    ]
    with fan_out(workers) as mapper, counting() as progress:
        task = progress.add_task("episodes", total=len(jobs))
        reports = []
        for report in mapper(_work, jobs):
            reports.append(report)
            progress.advance(task)
    content, rows = _summary(reports, scenarios)
    faults = [f"{report.family}-{report.seed}: {report.fault}" for report in reports if report.fault]
    flag = "" if repeat else " --no-repeat"
    command = f"./roadmend bench outcomes --policy {policy} --repair {method} --scenarios {scenarios}{flag}"
    if first_seed:
        command += f" --first-seed {first_seed}"
    content = {"provenance": provenance(command), "policy": policy, "method": method, "faults": faults} | content
    title = f"{policy} with repair {method} in random scenarios"
    Figures(f"outcomes-{policy}-{method}", title, content, rows).publish(out, as_json=as_json)
    for fault in faults:
        click.echo(fault, err=True)
    return 1 if faults else 0


def _summary(reports: list[_Report], scenarios: int) -> tuple[dict[str, Any], list[list[str]]]:
    families: dict[str, Any] = {}
    rows = [["family", *(outcome.name.lower() for outcome in _OUTCOMES), "goal share", "95 % interval"]]
    for family in FAMILIES:
        counts = Counter(report.outcome for report in reports if report.family == family)
        low, high = wilson(counts["GOAL"], scenarios)
        families[family] = {
            "counts": dict(counts),
            "goal_share": counts["GOAL"] / scenarios,
            "interval": [low, high],
        }
        cells = [str(counts[outcome.name]) for outcome in _OUTCOMES]
        share = f"{100 * counts['GOAL'] / scenarios:.1f} %"
        rows.append([family, *cells, share, f"{100 * low:.1f} .. {100 * high:.1f} %"])
    return {"scenarios_a_family": scenarios, "families": families}, rows
