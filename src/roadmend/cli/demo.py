"""``roadmend demo``: the main job, end to end."""

import json
import sys
import time
from pathlib import Path

import click

from roadmend.cli.resources import config_folder
from roadmend.cli.run import run_with_status
from roadmend.cli.table import show_results, wide_console
from roadmend.core.errors import RoadmendError
from roadmend.nodes.launcher import GraphOptions, RunResult

_METHODS = ("none", "adreft")


@click.command()
@click.option(
    "--out", default=Path("bags"), show_default=True, type=click.Path(path_type=Path), help="Folder for the bags."
)
@click.option("--json", "as_json", is_flag=True, help="Print the results as JSON.")
def demo(out: Path, *, as_json: bool) -> None:
    """Drive scenarios with the bare policy and with repair, as real node processes, and compare.

    Fails unless the bare policy collides and the repaired one reaches its goal in at least one of them.
    """
    stamp = time.strftime("%Y%m%d-%H%M%S")
    results: list[RunResult] = []
    repaired = False
    for scenario in sorted((config_folder() / "scenarios").glob("demo-*.yaml")):
        pair = [
            run_with_status(GraphOptions(scenario, method=method, bags=out, name=f"{scenario.stem}-{method}-{stamp}"))
            for method in _METHODS
        ]
        results += pair
        repaired |= [result.outcome for result in pair] == ["COLLISION", "GOAL"]
    if as_json:
        json.dump([result.as_dict() for result in results], sys.stdout, indent=2)
        sys.stdout.write("\n")
    else:
        show_results(results, wide_console())
        _explain(results)
    if not repaired:
        raise RoadmendError(
            "in no scenario did the bare policy collide and the repaired one arrive; please report this"
        )


def _explain(results: list[RunResult]) -> None:
    console = wide_console()
    shown = next((result for result in results if result.interventions and result.outcome == "GOAL"), results[-1])
    console.print(f"\nA picture of the moment: [bold]./roadmend bag plot {shown.bag}[/]", highlight=False)
    console.print(
        "Or open the bag's .mcap in Foxglove, with the layout config/foxglove/roadmend.json.", highlight=False
    )
