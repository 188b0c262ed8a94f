"""``roadmend run``: one episode in the graph."""

import json
import re
import sys
import tempfile
from pathlib import Path

import click
from rich.console import Console

from roadmend.cli.table import show_results, wide_console
from roadmend.core.errors import InputError, RoadmendError
from roadmend.nodes.launcher import GraphOptions, InterruptedRunError, RunResult, run_graph
from roadmend.policies.registry import POLICIES
from roadmend.repair.registry import METHODS
from roadmend.world.scenario import Scenario
from roadmend.world.scenario_file import load_scenario, parse_scenario, save_scenario

_SCENARIO_FIELDS = ("ego.", "actors[", "network.")


@click.command(context_settings={"ignore_unknown_options": True})
@click.option("--scenario", type=click.Path(path_type=Path), help="Scenario file (see 'roadmend sample').")
@click.option(
    "--sumocfg", type=click.Path(path_type=Path), help="A SUMO configuration of your own; an ego joins its traffic."
)
@click.option(
    "--ego-route",
    help="With --sumocfg: edges of the ego's route, separated by spaces; one of the traffic's if not given.",
)
@click.option(
    "--warm-up",
    default=600.0,
    show_default=True,
    type=click.FloatRange(0.0),
    help="With --sumocfg: seconds of traffic before the ego enters.",
)
@click.option(
    "--time-limit",
    default=60.0,
    show_default=True,
    type=click.FloatRange(0.1),
    help="With --sumocfg: seconds to drive.",
)
@click.option("--policy", default="modular", show_default=True, type=click.Choice(sorted(POLICIES)))
@click.option("--repair", "method", default="rss", show_default=True, type=click.Choice(sorted(METHODS)))
@click.option("--clock", default="lockstep", show_default=True, type=click.Choice(["lockstep", "realtime"]))
@click.option(
    "--rate",
    default=1.0,
    show_default=True,
    type=click.FloatRange(0.01, 100.0),
    help="Real time: simulated seconds per second.",
)
@click.option(
    "--seed",
    default=0,
    show_default=True,
    type=click.IntRange(0, 2**31 - 1),
    help="Seed of repair methods that draw numbers.",
)
@click.option(
    "--out", default=Path("bags"), show_default=True, type=click.Path(path_type=Path), help="Folder for the bag."
)
@click.option("--name", default="", help="Name of the bag.  [default: from scenario, policy, method and time]")
@click.option("--record/--no-record", default=True, show_default=True)
@click.option("--viz/--no-viz", default=True, show_default=True, help="Markers and frames for Foxglove.")
@click.option(
    "--foxglove",
    is_flag=False,
    flag_value=8765,
    type=click.IntRange(1, 65535),
    metavar="[PORT]",
    help="Show the graph in Foxglove, live at ws://127.0.0.1:PORT; best with --clock realtime.  [PORT: 8765]",
)
@click.option("--json", "as_json", is_flag=True, help="Print the result as JSON.")
@click.argument("ros_arguments", nargs=-1, type=click.UNPROCESSED, metavar="[--ros-args ...]")
def run(
    scenario: Path | None,
    sumocfg: Path | None,
    ego_route: str | None,
    warm_up: float,
    time_limit: float,
    policy: str,
    method: str,
    clock: str,
    rate: float,
    seed: int,
    out: Path,
    name: str,
    *,
    record: bool,
    viz: bool,
    foxglove: int | None,
    as_json: bool,
    ros_arguments: tuple[str, ...],
) -> None:
    """Run one episode in the graph: SUMO, policy, repair and recorder as separate processes.

    Everything after --ros-args goes to every node.
    """
    if (scenario is None) == (sumocfg is None):
        raise click.UsageError("give either --scenario or --sumocfg")
    if ros_arguments and ros_arguments[0] != "--ros-args":
        raise click.UsageError(f"unexpected argument {ros_arguments[0]!r}")
    with tempfile.TemporaryDirectory(prefix="roadmend-") as folder:
        if scenario is not None:
            chosen = load_scenario(scenario)
            stem = scenario.stem
        else:
            chosen = _for_configuration(Path(str(sumocfg)), ego_route, warm_up, time_limit)
            stem = chosen.name
        path = Path(folder) / f"{stem}.yaml"
        save_scenario(chosen, path)  # paths made absolute
        options = GraphOptions(
            path, policy, method, clock, rate, seed, out, name, record, viz, foxglove, tuple(ros_arguments[1:])
        )
        try:
            result = run_with_status(options)
        except InputError as error:
            if error.where.startswith(_SCENARIO_FIELDS):  # the nodes know a copy of the file
                raise InputError(f"{scenario or sumocfg}: {error.where}", error.what, error.mend) from None
            raise
        except InterruptedRunError as error:
            if error.result is not None:
                _show([error.result], as_json=as_json)
            raise
    _show([result], as_json=as_json)
    if result.recording_error:
        raise RoadmendError(result.recording_error)


def _for_configuration(path: Path, ego_route: str | None, warm_up: float, time_limit: float) -> Scenario:
    if not path.is_file():
        raise InputError(str(path), "no such file", "give the path of a SUMO .sumocfg file")
    name = re.sub(r"[^A-Za-z0-9_.-]", "_", path.parent.resolve().name)
    content = {
        "name": name or "sumocfg",
        "time_limit": time_limit,
        "network": {"kind": "sumocfg", "path": str(path.resolve()), "warm_up": warm_up},
        "ego": {"route": ego_route.split() if ego_route else [], "speed": 0.0},
    }
    return parse_scenario(content, str(path))


def run_with_status(options: GraphOptions, label: str = "") -> RunResult:
    """Run the graph with a status line while it lasts."""
    console = Console(stderr=True)
    label = label or f"{options.scenario.stem} · {options.policy} · {options.method}"
    with console.status(f"{label}: starting the graph") as status:

        def report(text: str, elapsed: float) -> None:
            if text != "running":
                console.print(f"{label}: {text}")
            status.update(f"{label}: {elapsed:.0f} s")

        return run_graph(options, report)


def _show(results: list[RunResult], *, as_json: bool) -> None:
    if as_json:
        json.dump([result.as_dict() for result in results], sys.stdout, indent=2)
        sys.stdout.write("\n")
        return
    show_results(results, wide_console())
