"""``roadmend safe test``: how a policy fares in the scenarios of crash reports."""

import json
from pathlib import Path

import click

from roadmend.cli.output import show_rows
from roadmend.cli.safe_work import open_cases, policies_option, shared_options, work_through
from roadmend.core.whole_file import write_texts
from roadmend.reports.crash_tests import report_of_tests
from roadmend.reports.trial_picture import draw_trial
from roadmend.safe.driving import Task
from roadmend.safe.planning import plan
from roadmend.safe.tally import tally_tests


@click.command(name="test")
@shared_options
@policies_option
@click.option("--samples", default=2, show_default=True, type=click.IntRange(1, 1000), help="Scenarios of each role.")
@click.option("--pictures/--no-pictures", default=True, show_default=True, help="Draw every scenario.")
def safe_test(
    paths: tuple[Path, ...],
    out: Path,
    seed: int,
    workers: int,
    policies: tuple[str, ...],
    samples: int,
    *,
    pictures: bool,
    as_json: bool,
) -> int:
    """Drive the scenarios of crash reports with a policy, and write report.md and report.html.

    PATHS as in 'roadmend safe build'. Exit code 1 if a report gave no scenario that runs.
    """
    cases = open_cases(paths)
    jobs = plan(Task.TEST, cases, policies, out, samples=samples, seed=seed, draw=draw_trial if pictures else None)
    results = work_through(jobs, out, workers, "episodes")
    tallies = {policy: tally_tests(cases, [each for each in results if each.policy == policy]) for policy in policies}
    write_texts(out, report_of_tests(cases, tallies, results, out))
    content = {policy: found.as_dict() for policy, found in tallies.items()}
    if as_json:
        click.echo(json.dumps(content, indent=2))
    else:
        titles = (
            "policy",
            "reports",
            "built",
            "scenarios",
            "collisions",
            "at fault",
            "violation rate",
            "top-1/2/3",
            "s per scenario",
        )
        show_rows([titles, *((policy, *found.cells()) for policy, found in tallies.items())])
        click.echo(f"report: {out / 'report.html'}")
    return 0 if all(found.built == found.reports for found in tallies.values()) else 1
