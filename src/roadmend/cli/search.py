"""``roadmend search``: find scenarios in which a policy under repair collides."""

import json
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Annotated

import click

from roadmend.cli.command import ExampleCommand
from roadmend.cli.driver_options import POLICY, REPAIR
from roadmend.cli.options import FILE, FOLDER, JSON, SEED, WORKERS, NameType, options_of
from roadmend.cli.output import counting, show_rows
from roadmend.cli.scenario import FAMILY
from roadmend.core.fanout import fan_out
from roadmend.core.yaml_file import read_fields
from roadmend.search.campaign import Campaign, CampaignSummary, run_campaign, summarise
from roadmend.search.evaluation import Subject, evaluate
from roadmend.search.ledger import Ledger, LedgerEntry
from roadmend.search.registry import TECHNIQUE_REGISTRY, read_technique_parameters


@dataclass(frozen=True)
class SearchOptions:
    """What is searched for, and how long."""

    family: Annotated[str, FAMILY]
    technique: Annotated[
        str,
        click.option("--technique", default="avfuzzer", show_default=True, type=NameType(TECHNIQUE_REGISTRY)),
    ]
    policy: Annotated[str, POLICY]
    method: Annotated[str, REPAIR]
    budget: Annotated[
        int,
        click.option(
            "--budget",
            default=200,
            show_default=True,
            type=click.IntRange(1, 1_000_000),
            help="Scenarios to run in all, those of earlier calls included.",
        ),
    ]
    seed: Annotated[int, SEED]
    file: Annotated[
        Path | None,
        click.option(
            "--parameters", "file", type=FILE, help="YAML file with parameters of the technique (see config/search)."
        ),
    ]
    out: Annotated[
        Path,
        click.option(
            "--out",
            required=True,
            type=FOLDER,
            help="Folder for the ledger and the scenarios found; a search that is there goes on.",
        ),
    ]
    workers: Annotated[int, WORKERS]
    as_json: Annotated[bool, JSON]


@click.command(
    cls=ExampleCommand,
    examples=["roadmend search --family S3 --policy modular --repair rss --budget 500 --out found"],
    resumes="",
)
@options_of(SearchOptions)
def search(given: SearchOptions) -> int:
    """Find scenarios in which a policy under repair collides by its own fault; exit code 1 if one could not be run.

    The same settings give the same scenarios, whatever the number of workers. Every one that ends in such a collision
    is written to the folder, with the command that shows it again in ledger.jsonl.
    """
    chosen = read_technique_parameters(
        given.technique, read_fields(given.file, "give names and values, see config/search") if given.file else None
    )
    campaign = Campaign(Subject(given.family, given.policy, given.method, given.seed), given.technique, chosen)
    with Ledger(given.out, campaign.settings) as ledger:
        with counting() as progress:
            violations = summarise(ledger.entries).violations
            task = progress.add_task(
                _label(violations), total=given.budget, completed=min(given.budget, len(ledger.entries))
            )

            def report(entry: LedgerEntry) -> None:
                nonlocal violations
                violations += entry.evaluation.is_violation
                progress.update(task, advance=1, description=_label(violations))

            with fan_out(given.workers) as mapper:
                run_campaign(
                    campaign, ledger, partial(mapper, partial(evaluate, campaign.subject)), given.budget, report
                )
        found = summarise(ledger.entries)
        faults = [entry.evaluation.fault for entry in ledger.entries if entry.evaluation.fault]
    if faults:
        click.echo(f"{len(faults)} of {found.evaluated} could not be run, first: {faults[0]}", err=True)
    if given.as_json:
        click.echo(json.dumps({**campaign.settings, **asdict(found), "folder": str(given.out)}, indent=2))
    else:
        _show(campaign, found)
    return 1 if found.crashes else 0


def _label(violations: int) -> str:
    return f"{violations} violation{'' if violations == 1 else 's'}"


def _show(campaign: Campaign, found: CampaignSummary) -> None:
    titles = (
        "family",
        "technique",
        "policy",
        "repair",
        "evaluated",
        "violations",
        "distinct",
        "first after",
        "crashes",
    )
    subject = campaign.subject
    row = (
        subject.family,
        campaign.technique,
        subject.policy,
        subject.method,
        str(found.evaluated),
        str(found.violations),
        str(found.distinct),
        str(found.first_violation or "-"),
        str(found.crashes),
    )
    show_rows([titles, row])
