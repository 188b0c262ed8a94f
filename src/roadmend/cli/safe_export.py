"""``roadmend safe export``: a scenario in the formats that other simulators read."""

import json
from pathlib import Path

import click

from roadmend.safe.openscenario import export_scenario
from roadmend.world.scenario_file import load_scenario


@click.command()
@click.argument("scenario", type=click.Path(path_type=Path, dir_okay=False))
@click.option("--out", required=True, type=click.Path(path_type=Path, file_okay=False), help="Folder for the files.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def export(scenario: Path, out: Path, *, as_json: bool) -> int:
    """Write a scenario as ASAM OpenSCENARIO (NAME.xosc) and its roads as OpenDRIVE (NAME.xodr).

    SCENARIO is any scenario file with a network of its own. The first call sets up the writer.
    """
    story, roads = export_scenario(load_scenario(scenario), out)
    if as_json:
        click.echo(json.dumps({"openscenario": str(story), "opendrive": str(roads)}, indent=2))
    else:
        click.echo(f"{story}\n{roads}")
    return 0
