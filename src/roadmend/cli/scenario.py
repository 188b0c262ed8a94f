"""``roadmend sample`` and ``roadmend schema``."""

import json
from pathlib import Path

import click

from roadmend.cli.command import ExampleCommand
from roadmend.cli.options import FILE, JSON, SEED, NameType, only_own
from roadmend.world.families import FAMILIES, FAMILY_REGISTRY, sample_scenario
from roadmend.world.scenario_file import dump_scenario, save_scenario, scenario_schema

FAMILY_NAME = NameType(FAMILY_REGISTRY)
FAMILY = click.option(
    "--family",
    required=True,
    type=FAMILY_NAME,
    help="; ".join(f"{family.name} {family.title}" for family in FAMILIES.values()),
)


@click.command(cls=ExampleCommand, examples=["roadmend sample --family S3 --seed 7 --out crossing.yaml"])
@FAMILY
@SEED
@click.option("--out", type=FILE, callback=only_own, help="File to write; standard output if not given.")
@JSON
def sample(family: str, seed: int, out: Path | None, *, as_json: bool) -> None:
    """Draw a scenario of a family.

    A scenario file is YAML, of which the JSON that --json prints is a kind: 'roadmend run' takes either.
    """
    scenario = sample_scenario(family, seed)
    if out is not None:
        save_scenario(scenario, out)
    if as_json:
        click.echo(json.dumps(scenario.model_dump(mode="json", exclude_none=True), indent=2))
    elif out is None:
        click.echo(dump_scenario(scenario), nl=False)
    else:
        click.echo(f"{out}: {scenario.name}, {len(scenario.actors)} actors, {scenario.environment.weather}")


@click.command(cls=ExampleCommand, examples=["roadmend schema > scenario.schema.json"])
def schema() -> None:
    """Print the JSON schema of a scenario file."""
    click.echo(json.dumps(scenario_schema(), indent=2))
