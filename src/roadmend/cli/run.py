"""``roadmend run``, ``roadmend demo`` and ``roadmend replay``: the graph, live or from a bag."""

import json
import os
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import click
from rich.console import Console
from rich.table import Table

from roadmend.cli.driver_options import METHOD_NAME, POLICY, REPAIR_SEED
from roadmend.cli.options import PATH, options_of
from roadmend.cli.output import OUTCOME_STYLES, wide_console
from roadmend.core.errors import InputError, RoadmendError
from roadmend.core.resources import config_folder
from roadmend.nodes.launcher import GraphOptions, InterruptedRunError, RunResult, run_graph
from roadmend.world.scenario_file import load_scenario, save_scenario, scenario_of_configuration

_SCENARIO_FIELDS = ("ego.", "actors[", "network.")


ROS_ARGUMENTS = click.argument("ros_arguments", nargs=-1, type=click.UNPROCESSED, metavar="[--ros-args ...]")


@dataclass(frozen=True)
class RunOptions:
    """What to run, and how."""

    scenario: Annotated[
        Path | None, click.option("--scenario", type=PATH, help="Scenario file (see 'roadmend sample').")
    ]
    sumocfg: Annotated[
        Path | None,
        click.option("--sumocfg", type=PATH, help="A SUMO configuration of your own; an ego joins its traffic."),
    ]
    ego_route: Annotated[
        str | None,
        click.option(
            "--ego-route",
            help="With --sumocfg: edges of the ego's route, separated by spaces; one of the traffic's if not given.",
        ),
    ]
    warm_up: Annotated[
        float,
        click.option(
            "--warm-up",
            default=600.0,
            show_default=True,
            type=click.FloatRange(0.0),
            help="With --sumocfg: seconds of traffic before the ego enters.",
        ),
    ]
    time_limit: Annotated[
        float,
        click.option(
            "--time-limit",
            default=60.0,
            show_default=True,
            type=click.FloatRange(0.1),
            help="With --sumocfg: seconds to drive.",
        ),
    ]
    policy: Annotated[str, POLICY]
    method: Annotated[str, click.option("--repair", "method", default="rss", show_default=True, type=METHOD_NAME)]
    clock: Annotated[
        str, click.option("--clock", default="lockstep", show_default=True, type=click.Choice(["lockstep", "realtime"]))
    ]
    rate: Annotated[
        float,
        click.option(
            "--rate",
            default=1.0,
            show_default=True,
            type=click.FloatRange(0.01, 100.0),
            help="Real time: simulated seconds per second.",
        ),
    ]
    seed: Annotated[int, REPAIR_SEED]
    out: Annotated[
        Path, click.option("--out", default=Path("bags"), show_default=True, type=PATH, help="Folder for the bag.")
    ]
    name: Annotated[
        str,
        click.option("--name", default="", help="Name of the bag.  [default: from scenario, policy, method and time]"),
    ]
    record: Annotated[bool, click.option("--record/--no-record", default=True, show_default=True)]
    viz: Annotated[
        bool, click.option("--viz/--no-viz", default=True, show_default=True, help="Markers and frames for Foxglove.")
    ]
    foxglove: Annotated[
        int | None,
        click.option(
            "--foxglove",
            is_flag=False,
            flag_value=8765,
            type=click.IntRange(1, 65535),
            metavar="[PORT]",
            help="Show the graph in Foxglove, live at ws://127.0.0.1:PORT; best with --clock realtime.  [PORT: 8765]",
        ),
    ]
    as_json: Annotated[bool, click.option("--json", "as_json", is_flag=True, help="Print the result as JSON.")]
    ros_arguments: Annotated[tuple[str, ...], ROS_ARGUMENTS]


@click.command(context_settings={"ignore_unknown_options": True})
@options_of(RunOptions)
def run(given: RunOptions) -> None:
    """Run one episode in the graph: SUMO, policy, repair and recorder as separate processes.

    Everything after --ros-args goes to every node.
    """
    if (given.scenario is None) == (given.sumocfg is None):
        raise click.UsageError("give either --scenario or --sumocfg")
    extra = ros_arguments(given.ros_arguments)
    with tempfile.TemporaryDirectory(prefix="roadmend-") as folder:
        if given.scenario is not None:
            chosen = load_scenario(given.scenario)
            stem = given.scenario.stem
        else:
            route = given.ego_route.split() if given.ego_route else []
            chosen = scenario_of_configuration(Path(str(given.sumocfg)), route, given.warm_up, given.time_limit)
            stem = chosen.name
        path = Path(folder) / f"{stem}.yaml"
        save_scenario(chosen, path)  # paths made absolute
        options = GraphOptions(
            path,
            given.policy,
            given.method,
            given.clock,
            given.rate,
            given.seed,
            given.out,
            given.name,
            given.record,
            given.viz,
            given.foxglove,
            extra,
        )
        try:
            result = run_with_status(options)
        except InputError as error:
            if error.where.startswith(_SCENARIO_FIELDS):  # the nodes know a copy of the file
                where = f"{given.scenario or given.sumocfg}: {error.where}"
                raise InputError(where, error.what, error.mend) from None
            raise
        except InterruptedRunError as error:
            if error.result is not None:
                _show([error.result], as_json=given.as_json)
            raise
    _show([result], as_json=given.as_json)
    for trouble in (result.policy_error, result.method_error, result.recording_error):
        if trouble:
            raise RoadmendError(trouble)


def ros_arguments(given: tuple[str, ...]) -> tuple[str, ...]:
    """What stands behind --ros-args.

    Raises:
        UsageError: there is something else.
    """
    if given and given[0] != "--ros-args":
        raise click.UsageError(f"unexpected argument {given[0]!r}")
    return given[1:]


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


def show_results(results: Sequence[RunResult], console: Console) -> None:
    """Print one row a run."""
    table = Table(box=None, pad_edge=False, header_style="bold")
    for title in ("scenario", "method", "outcome"):
        table.add_column(title, no_wrap=True)
    for title in ("min\ndistance", "inter-\nventions", "intensity", "real-time\nfactor"):
        table.add_column(title, justify="right", no_wrap=True)
    table.add_column("bag", overflow="fold")
    for result in results:
        episode = result.episode
        distance = "-" if episode.min_distance is None else f"{episode.min_distance:.2f} m"
        table.add_row(
            episode.scenario,
            episode.method,
            f"[{OUTCOME_STYLES.get(episode.outcome.name, 'white')}]{episode.outcome.name}[/]",
            distance,
            str(episode.interventions),
            f"{episode.intensity:.2f}" if episode.interventions else "-",
            f"{result.real_time_factor:.1f} x",
            result.bag or "-",
        )
    console.print(table)


_METHODS = ("none", "adreft")


@click.command()
@click.option("--out", default=Path("bags"), show_default=True, type=PATH, help="Folder for the bags.")
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
        repaired |= pair[0].episode.collided and pair[1].episode.reached_goal
    _show(results, as_json=as_json)
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
    home = config_folder().parent
    is_clone = (home / "roadmend").is_file()  # else a wheel has put the command on the PATH, and its data elsewhere
    layout = (Path("config") if is_clone else config_folder()) / "foxglove" / "roadmend.json"
    command = "./roadmend" if is_clone else "roadmend"
    console.print(f"\nA picture of the moment: [bold]{command} bag plot {shown.bag}[/]", highlight=False)
    console.print(f"Or open the bag's .mcap in Foxglove, with the layout {layout}.", highlight=False)


@dataclass(frozen=True)
class ReplayOptions:
    """What to play, and how."""

    bag: Annotated[Path, click.argument("bag", type=PATH)]
    rate: Annotated[
        float,
        click.option(
            "--rate",
            default=1.0,
            show_default=True,
            type=click.FloatRange(1e-3, 1e3),
            help="Recorded seconds per second.",
        ),
    ]
    start: Annotated[
        float,
        click.option(
            "--start",
            default=0.0,
            show_default=True,
            type=click.FloatRange(0.0),
            help="Begin this many seconds into the bag.",
        ),
    ]
    loop: Annotated[bool, click.option("--loop", is_flag=True, help="Begin again at the end.")]
    topics: Annotated[
        tuple[str, ...],
        click.option(
            "--topic", "topics", multiple=True, help="Play this topic, and the clock; may be repeated.  [default: all]"
        ),
    ]
    exclude: Annotated[
        tuple[str, ...], click.option("--exclude", multiple=True, help="Do not play this topic; may be repeated.")
    ]
    paused: Annotated[
        bool,
        click.option("--paused", is_flag=True, help="Wait for the service replay_node/resume or replay_node/step."),
    ]
    lockstep: Annotated[
        bool,
        click.option(
            "--lockstep",
            is_flag=True,
            help="Play no repairs: each tick waits for those of a live repair_node, at any rate.",
        ),
    ]
    wait_for: Annotated[
        tuple[str, ...],
        click.option("--wait-for", multiple=True, help="Begin when this node listens; may be repeated."),
    ]
    wait_for_listeners: Annotated[
        bool,
        click.option(
            "--wait-for-listeners", is_flag=True, help="Begin when every topic has a listener, such as a recorder."
        ),
    ]
    ros_arguments: Annotated[tuple[str, ...], ROS_ARGUMENTS]


@click.command(context_settings={"ignore_unknown_options": True})
@options_of(ReplayOptions)
def replay(given: ReplayOptions) -> int:
    """Publish what a bag holds, with the QoS it was recorded with, and the clock.

    Remap topics with --ros-args -r OLD:=NEW, put all but the clock into a namespace with -r __ns:=/NAME.
    """
    extra = ros_arguments(given.ros_arguments)
    from roadmend.nodes.replay import main  # noqa: PLC0415 - rclpy is for this command alone

    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    parameters: dict[str, Any] = {
        "bag": str(given.bag),
        "rate": given.rate,
        "start_offset": given.start,
        "loop": given.loop,
        "topics": given.topics or [""],
        "exclude": given.exclude or [""],
        "start_paused": given.paused,
        "clock": "lockstep" if given.lockstep else "realtime",
        "wait_for": given.wait_for or [""],
        "wait_for_listeners": given.wait_for_listeners,
    }
    words = [word for name, value in parameters.items() for word in ("-p", f"{name}:={json.dumps(value)}")]
    return main(["replay_node", "--ros-args", *words, *extra])
