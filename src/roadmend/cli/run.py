"""``roadmend run``: an episode in the graph."""

import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import click
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from roadmend.cli.command import ExampleCommand
from roadmend.cli.driver_options import METHOD_NAME, RUN_POLICY, TUNED
from roadmend.cli.options import BAGS, JSON, PATH, RECORD, Number, options_of
from roadmend.cli.output import OUTCOME_STYLES, Waiting, wide_console
from roadmend.cli.ros_arguments import ROS_ARGUMENTS, ros_arguments
from roadmend.cli.sumo_options import TIME_LIMIT, WARM_UP, WARM_UP_OPTION, egos, sumocfg, time_limit
from roadmend.core.errors import InputError, RoadmendError
from roadmend.nodes.graph_options import GraphOptions
from roadmend.nodes.launcher import run_graph
from roadmend.nodes.run_result import InterruptedRunError, RunResult, complaint_of, gap_of
from roadmend.nodes.scratch import scratch_folder
from roadmend.nodes.supervisor import FRESH_S, LOCKSTEP_SILENCE_S, REALTIME_SILENCE_S, START_S
from roadmend.world.scenario import Scenario
from roadmend.world.scenario_file import drawn_scenarios, load_scenario, save_scenario, scenario_of_configuration

_SCENARIO_FIELDS = ("ego.", "actors[", "network.")


@dataclass(frozen=True)
class RunOptions:
    """What to run, and how."""

    scenario: Annotated[
        Path | None, click.option("--scenario", type=PATH, help="Scenario file (see 'roadmend sample').")
    ]
    sumocfg: Annotated[
        Path | None,
        sumocfg("A SUMO configuration of your own, or a network alone, which gets traffic; an ego joins that traffic."),
    ]
    ego_route: Annotated[
        str | None,
        click.option(
            "--ego-route",
            help="With --sumocfg: edges of the ego's route, separated by spaces.  [default: drawn by the seed]",
        ),
    ]
    egos: Annotated[int | None, egos("1")]
    warm_up: Annotated[float | None, WARM_UP_OPTION]
    time_limit: Annotated[
        float | None,
        time_limit(
            f"With --sumocfg: seconds to drive.  [default: {TIME_LIMIT:g}, to which routes are drawn; with --ego-route as "
            "long as that takes]"
        ),
    ]
    policy: Annotated[str, RUN_POLICY]
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
            type=Number(0.01, 100.0),
            help="Real time: simulated seconds per second.",
        ),
    ]
    tuned: Annotated[bool, TUNED]
    seed: Annotated[
        int,
        click.option(
            "--seed",
            default=0,
            show_default=True,
            type=click.IntRange(0, 2**30),
            help="Of repair methods that draw numbers; with --sumocfg also of the first ego's traffic, start and route.",
        ),
    ]
    out: Annotated[Path, BAGS]
    name: Annotated[
        str,
        click.option("--name", default="", help="Name of the bag.  [default: from scenario, policy, method and time]"),
    ]
    record: Annotated[bool, RECORD]
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
    start_deadline: Annotated[
        float | None,
        click.option(
            "--start-deadline",
            type=Number(0.0, 86400.0),
            help="Seconds in which the drive must begin; 0 waits for ever.  "
            f"[default: {START_S:g}; 0 with --policy external]",
        ),
    ]
    silence: Annotated[
        float | None,
        click.option(
            "--silence",
            type=Number(1.0, 86400.0),
            help="Seconds without a sign of life after which a node is ended and started anew.  "
            f"One that has only just come up has {FRESH_S:g} at least.  "
            f"[default: {LOCKSTEP_SILENCE_S:g} in lockstep, {REALTIME_SILENCE_S:g} in real time]",
        ),
    ]
    as_json: Annotated[bool, JSON]
    ros_arguments: Annotated[tuple[str, ...], ROS_ARGUMENTS]


@click.command(
    context_settings={"ignore_unknown_options": True},
    cls=ExampleCommand,
    examples=[
        "roadmend run --scenario config/scenarios/demo-exit.yaml --policy modular --repair adreft",
        "roadmend run --sumocfg my/town.sumocfg --repair adreft",
        "roadmend run --sumocfg my/town.net.xml.gz --no-record --json",
    ],
)
@options_of(RunOptions)
def run(given: RunOptions) -> int:
    """Run one episode in the graph: SUMO, policy, repair and recorder as separate processes.

    Everything after --ros-args goes to every node. In a SUMO configuration one episode for every ego; those that cannot
    be driven are named, and the exit code is then 1, or 2 if none could be driven. It is 1 too where the policy, the
    method or the recorder failed, and where a node ended, hung or fell silent.
    """
    extra = ros_arguments(given.ros_arguments)  # first: an option that is misspelled is among them
    if (given.scenario is None) == (given.sumocfg is None):
        raise click.UsageError("give either --scenario or --sumocfg")
    if given.rate != 1.0 and given.clock == "lockstep":
        raise click.UsageError("--rate is of --clock realtime; in lockstep a drive is as fast as the machine")
    if given.name and not given.record:
        raise click.UsageError("--name is of a bag, and --no-record makes none")
    try:
        chosen = _scenarios(given)
    except InputError as error:
        raise _placed(error, given) from None
    results: list[RunResult] = []
    faults: list[RoadmendError] = []
    with scratch_folder("roadmend-") as folder:
        for number, scenario in enumerate(chosen):
            stem = given.scenario.stem if given.scenario is not None else scenario.name
            path = folder / f"{stem}.yaml"
            save_scenario(scenario, path)  # paths made absolute
            options = GraphOptions(
                path,
                given.policy,
                given.method,
                given.clock,
                given.rate,
                given.seed + number,
                given.out,
                f"{given.name}-{number}" if given.name and len(chosen) > 1 else given.name,
                given.record,
                given.viz,
                given.foxglove,
                given.tuned,
                extra,
                given.start_deadline,
                given.silence,
            )
            try:
                results.append(run_with_status(options))
            except InputError as error:
                fault = _placed(error, given)
                if len(chosen) == 1:
                    raise fault from None
                faults.append(fault)
            except InterruptedRunError as error:
                results += [error.result] if error.result is not None else []
                if results:
                    print_results(results, as_json=given.as_json)
                raise
            except RoadmendError as error:
                if not results and not faults:  # nothing has been tried before: it may well be of all
                    raise
                faults.append(RoadmendError(f"{scenario.name}: {error}"))
    if results or given.as_json:
        print_results(results, as_json=given.as_json)
    for each in faults:
        click.echo(f"roadmend: {each}", err=True)
    for result in results:
        if complaint := complaint_of(result):
            click.echo(f"roadmend: {complaint}", err=True)
        if result.lost_messages:
            click.echo(f"roadmend: {gap_of(result.bag, result.lost_messages)}", err=True)
    troubles = [(result, trouble) for result in results for trouble in _troubles(result)]
    for result, trouble in troubles:
        click.echo(
            f"roadmend: {result.episode.scenario}: {trouble}" if len(chosen) > 1 else f"roadmend: {trouble}", err=True
        )
    if not results:
        return 2
    return 1 if faults or troubles else 0


def _troubles(result: RunResult) -> list[str]:
    """Each reason for which a run that has ended ends with 1, once; what the others may follow from is the last."""
    told = ("; ".join(result.faults), result.recording_error, result.method_error, result.policy_error)
    return [*dict.fromkeys(filter(None, told))]


def _scenarios(given: RunOptions) -> list[Scenario]:
    """What shall be driven."""
    if given.scenario is not None:
        for option, value in (("--egos", given.egos), ("--ego-route", given.ego_route), ("--warm-up", given.warm_up)):
            if value is not None:
                raise InputError(option, "is of a SUMO configuration, and there is none", "name one with --sumocfg")
        if given.time_limit is not None:
            raise InputError("--time-limit", "is of a SUMO configuration", "set time_limit in the scenario file")
        return [load_scenario(given.scenario)]
    path, warm_up = Path(str(given.sumocfg)), WARM_UP if given.warm_up is None else given.warm_up
    seeds = range(given.seed, given.seed + (given.egos or 1))
    if given.ego_route is None:
        return drawn_scenarios([path], seeds, warm_up, TIME_LIMIT if given.time_limit is None else given.time_limit)
    route = given.ego_route.split()
    if not route:  # as of a variable of the shell that is not set: no route is not one that may be drawn
        raise InputError("--ego-route", "names no edge", "name some, separated by spaces, or leave the option out")
    found = [scenario_of_configuration(path, route, warm_up, given.time_limit, seed) for seed in seeds]
    return (
        found if len(found) == 1 else [each.model_copy(update={"name": f"{each.name}-{each.seed}"}) for each in found]
    )


def _placed(error: InputError, given: RunOptions) -> InputError:
    """The error with the file that the user knows, where it names a field of the nodes' copy."""
    if error.where.startswith(_SCENARIO_FIELDS):
        return InputError(f"{given.scenario or given.sumocfg}: {error.where}", error.what, error.mend)
    return error


def run_with_status(options: GraphOptions, label: str = "") -> RunResult:
    """Run the graph with a status line while it lasts."""
    label = label or f"{options.scenario.stem} · {options.policy} · {options.method}"
    with Waiting(label) as waiting:
        waiting.update("starting the graph")

        def report(text: str, elapsed: float) -> None:
            if text != "running":
                waiting.say(text)
            waiting.update(f"{elapsed:.0f} s")

        return run_graph(options, report)


def print_results(results: list[RunResult], *, as_json: bool) -> None:
    """Print the results as a table, or as JSON."""
    if as_json:
        json.dump([result.as_dict() for result in results], sys.stdout, indent=2)
        sys.stdout.write("\n")
        return
    show_results(results, wide_console())


def show_results(results: Sequence[RunResult], console: Console) -> None:
    """Print one row a run."""
    table = Table(box=None, pad_edge=False, header_style="bold")
    for title in ("scenario", "policy", "method", "outcome"):
        table.add_column(title, no_wrap=True)
    for title in ("min\ndistance", "inter-\nventions", "intensity", "real-time\nfactor"):
        table.add_column(title, justify="right", no_wrap=True)
    table.add_column("bag", overflow="fold")
    for result in results:
        episode = result.episode
        distance = "-" if episode.min_distance is None else f"{episode.min_distance:.2f} m"
        table.add_row(
            escape(episode.scenario),
            escape(episode.policy),
            escape(episode.method),
            f"[{OUTCOME_STYLES.get(episode.outcome.name, 'white')}]{episode.outcome.name}[/]",
            distance,
            str(episode.interventions),
            f"{episode.intensity:.2f}" if episode.interventions else "-",
            f"{result.real_time_factor:.1f} x",
            escape(result.bag or "-") + (f" ({result.lost_messages} messages lost)" if result.lost_messages else ""),
        )
    console.print(table)
