"""``roadmend safe reproduce``: search for the crash that a report describes."""

import json
from pathlib import Path

import click

from roadmend.cli.output import show_rows
from roadmend.cli.safe_work import open_cases, policies_option, shared_options, work_through
from roadmend.core.whole_file import write_texts
from roadmend.reports.crash_tests import report_of_reproductions
from roadmend.reports.trial_picture import draw_trial
from roadmend.safe.driving import Task
from roadmend.safe.planning import plan
from roadmend.safe.tally import tally_reproductions


@click.command()
@shared_options
@policies_option
@click.option("--budget", default=36, show_default=True, type=click.IntRange(1, 100_000), help="Episodes of each role.")
@click.option("--pictures/--no-pictures", default=True, show_default=True, help="Draw every crash.")
def reproduce(
    paths: tuple[Path, ...],
    out: Path,
    seed: int,
    workers: int,
    policies: tuple[str, ...],
    budget: int,
    *,
    pictures: bool,
    as_json: bool,
) -> int:
    """Vary what a report leaves open until the described crash happens with the policy in a vehicle's place.

    PATHS as in 'roadmend safe build'. A crash counts as reproduced if it happens with the policy in the place of at
    least one of its vehicles: between the vehicles, from the directions, in the manoeuvres and with the one running
    into the other that the report gives, as far as it gives them.
    """
    cases = open_cases(paths)
    jobs = plan(Task.REPRODUCE, cases, policies, out, budget=budget, seed=seed, draw=draw_trial if pictures else None)
    results = work_through(jobs, out, workers, "roles")
    tallies = {
        policy: tally_reproductions(cases, [each for each in results if each.policy == policy]) for policy in policies
    }
    write_texts(out, report_of_reproductions(cases, tallies, results, out))
    if as_json:
        click.echo(json.dumps({policy: found.as_dict() for policy, found in tallies.items()}, indent=2))
        return 0
    titles = ("policy", "reports", "reproduced", "share", "of those with two vehicles or more", "episodes")
    show_rows([titles, *((policy, *found.cells()) for policy, found in tallies.items())])
    click.echo(f"report: {out / 'reproduction.html'}")
    return 0
