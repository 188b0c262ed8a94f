"""``roadmend safe build``: scenarios from crash reports."""

import json
from pathlib import Path

import click

from roadmend.cli.safe_work import open_cases, shared_options, work_through
from roadmend.safe.driving import Task
from roadmend.safe.planning import plan


@click.command()
@shared_options
@click.option("--samples", default=2, show_default=True, type=click.IntRange(1, 1000), help="Scenarios of each role.")
def build(paths: tuple[Path, ...], out: Path, seed: int, workers: int, samples: int, *, as_json: bool) -> int:
    """Build scenarios: every vehicle of a crash takes the place of the ego in turn.

    PATHS are crash reports (folders with a summary.txt), files of the scenario language, or folders of either. What a
    report leaves open is drawn from the seed and stands in each scenario under 'origin'. Exit code 1 if a report gave
    none.
    """
    cases = open_cases(paths)
    results = work_through(plan(Task.BUILD, cases, [""], out, samples=samples, seed=seed), out, workers, "scenarios")
    built = {result.report for result in results if result.scenario}
    failed = [result for result in results if not result.scenario]
    content = {
        "reports": len(cases),
        "built": len(built),
        "scenarios": [result.scenario for result in results if result.scenario],
        "failed": {case.name: case.problem for case in cases if case.crash is None}
        | {f"{result.report}-v{result.vehicle}": result.text for result in failed},
    }
    if as_json:
        click.echo(json.dumps(content, indent=2))
    else:
        for result in failed:
            click.echo(f"{result.report}, vehicle {result.vehicle}: {result.text}", err=True)
        click.echo(f"{len(results) - len(failed)} scenarios from {len(built)} of {len(cases)} reports in {out}")
    return 0 if len(built) == len(cases) else 1
