"""``roadmend sample`` and ``roadmend schema``."""

import json
from pathlib import Path

import click

from roadmend.cli.options import FILE, SEED, NameType
from roadmend.world.families import FAMILIES, FAMILY_REGISTRY, sample_scenario
from roadmend.world.scenario_file import dump_scenario, save_scenario, scenario_schema

FAMILY_NAME = NameType(FAMILY_REGISTRY)
FAMILY = click.option(
    "--family",
    required=True,
    type=FAMILY_NAME,
    help="; ".join(f"{family.name} {family.title}" for family in FAMILIES.values()),
)


@click.command()
@FAMILY
@SEED
@click.option("--out", type=FILE, help="File to write; standard output if not given.")
def sample(family: str, seed: int, out: Path | None) -> None:
    """Draw a scenario of a family."""
    scenario = sample_scenario(family, seed)
    if out is None:
        click.echo(dump_scenario(scenario), nl=False)
        return
    save_scenario(scenario, out)
    click.echo(f"{out}: {scenario.name}, {len(scenario.actors)} actors, {scenario.environment.weather}")


@click.command()
def schema() -> None:
    """Print the JSON schema of a scenario file."""
    click.echo(json.dumps(scenario_schema(), indent=2))
