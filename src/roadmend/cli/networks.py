"""``roadmend networks``: SUMO configurations to test on that nobody has built for roadmend."""

import json
from pathlib import Path

import click

from roadmend.cli.command import ExampleCommand
from roadmend.cli.options import FOLDER, JSON, WORKERS
from roadmend.cli.output import counting
from roadmend.core.errors import InputError
from roadmend.core.fanout import fan_out
from roadmend.world.procedural_networks import FIRST_TRAINING_SEED, KINDS, NetworkRequest, generate_configuration


@click.command(cls=ExampleCommand, examples=["roadmend networks --kind city --kind motorway --count 5 --out nets"])
@click.option("--kind", "kinds", multiple=True, type=click.Choice(KINDS), help="May be repeated.  [default: all]")
@click.option("--count", default=5, show_default=True, type=click.IntRange(1, 10_000), help="Of each kind.")
@click.option(
    "--seed",
    default=0,
    show_default=True,
    type=click.IntRange(0, 2**30),
    help=f"Of the first. Seeds below {FIRST_TRAINING_SEED} are for tests of methods, from there up for training.",
)
@click.option("--out", required=True, type=FOLDER, help="Folder for a folder each.")
@WORKERS
@JSON
def networks(kinds: tuple[str, ...], count: int, seed: int, out: Path, workers: int, *, as_json: bool) -> None:
    """Make SUMO configurations, with roads and traffic by SUMO's own generators, each from its kind and seed.

    'roadmend evaluate --sumocfg' drives on them, and 'roadmend run --sumocfg' too. A kind and a seed give the same
    files every time.
    """
    if seed < FIRST_TRAINING_SEED < seed + count:
        what = f"{seed} to {seed + count - 1} are seeds for tests and seeds for training"
        raise InputError("--seed", what, f"stay below {FIRST_TRAINING_SEED} or begin there")
    seeds = range(seed, seed + count)
    requests = [NetworkRequest(kind, number, out) for kind in dict.fromkeys(kinds or KINDS) for number in seeds]
    made: list[str] = []
    with fan_out(workers, len(requests)) as mapper, counting() as progress:
        task = progress.add_task("configurations", total=len(requests))
        for path in mapper(generate_configuration, requests):
            progress.update(task, advance=1)
            made.append(str(path))
            if not as_json:
                click.echo(path)
    if as_json:
        click.echo(json.dumps(made, indent=2))
