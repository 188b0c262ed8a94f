"""``roadmend demo``: a collision repaired, end to end."""

import shlex
import time
from pathlib import Path

import click
from rich.markup import escape

from roadmend.cli.command import ExampleCommand, called_as
from roadmend.cli.options import JSON, PATH
from roadmend.cli.output import wide_console
from roadmend.cli.run import print_results, run_with_status
from roadmend.core.errors import RoadmendError
from roadmend.core.resources import config_folder
from roadmend.nodes.graph_options import GraphOptions
from roadmend.nodes.run_result import RunResult

_METHODS = ("none", "adreft")


@click.command(cls=ExampleCommand, examples=["roadmend demo"])
@click.option("--out", default=Path("bags"), show_default=True, type=PATH, help="Folder for the bags.")
@JSON
def demo(out: Path, *, as_json: bool) -> None:
    """Drive scenarios with the bare policy and with repair, as real node processes, and compare.

    Fails unless the bare policy collides and the repaired one reaches its goal in at least one of them.
    """
    stamp = time.strftime("%Y%m%d-%H%M%S")
    results: list[RunResult] = []
    repaired = False
    for scenario in sorted((config_folder() / "scenarios").glob("demo-*.yaml")):
        pair = [
            run_with_status(
                GraphOptions(scenario, method=method, bags=out, name=f"{scenario.stem}-{method}-{stamp}", tuned=True)
            )
            for method in _METHODS
        ]
        results += pair
        repaired |= pair[0].episode.collided and pair[1].episode.reached_goal
    print_results(results, as_json=as_json)
    if not as_json:
        _explain(results)
    if not repaired:
        raise RoadmendError(
            "in no scenario did the bare policy collide and the repaired one arrive; please report this"
        )


def _explain(results: list[RunResult]) -> None:
    console = wide_console()
    good = (result for result in results if result.episode.interventions and result.episode.reached_goal)
    shown = next(good, results[-1])
    layout = config_folder() / "foxglove" / "roadmend.json"
    layout = layout.relative_to(Path.cwd()) if layout.is_relative_to(Path.cwd()) else layout
    command = escape(f"{called_as()} bag plot {shlex.quote(shown.bag)}")
    console.print(f"\nA picture of the moment: [bold]{command}[/]", highlight=False, soft_wrap=True)
    console.print(f"Or open the bag's .mcap in Foxglove, with the layout {layout}.", highlight=False, markup=False)
