"""``roadmend bag resimulate``: a recorded run driven again with another repair method, closed loop."""

import json
from dataclasses import asdict
from pathlib import Path

import click
from rich.console import Console
from rich.table import Table

from roadmend import __version__
from roadmend.cli.repair_choice import RepairChoice, read_choice, repair_options
from roadmend.cli.table import OUTCOME_STYLES, wide_console
from roadmend.core.errors import InputError
from roadmend.nodes.episode_recorder import EpisodeRecorder, account_of
from roadmend.policies.registry import make_policy
from roadmend.recording.new_bag import new_bag
from roadmend.recording.reader import BagReader
from roadmend.recording.recorded_run import (
    RECORD,
    RunOutcome,
    driven_outcome,
    read_plan,
    recorded_outcome,
)
from roadmend.recording.resimulation import Switchover
from roadmend.recording.ticks import BagTicks
from roadmend.world.runner import run_episode


@click.command()
@click.argument("bag", type=click.Path(path_type=Path))
@repair_options
@click.option(
    "--from-time",
    default=0.0,
    show_default=True,
    type=click.FloatRange(0.0),
    help="Simulation time [s] at which the method takes over; until then the recorded commands are driven.",
)
@click.option("--out", required=True, type=click.Path(path_type=Path), help="Folder of the new bag.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def resimulate(
    bag: Path,
    method: str,
    settings: tuple[str, ...],
    model: Path | None,
    seed: int,
    from_time: float,
    out: Path,
    *,
    as_json: bool,
) -> None:
    """Drive the scenario of a recorded run again, with another repair method from the start or from a moment on.

    Until that moment the run must repeat itself bit for bit, or the command ends with what differs.
    """
    choice = read_choice(method, settings, model, seed)
    then, now = resimulate_bag(bag, choice, from_time, out)
    if as_json:
        content = {"then": asdict(then), "now": asdict(now), "from_time": from_time, "bag": str(out)}
        click.echo(json.dumps({**content, "choice": choice.provenance()}, indent=2))
    else:
        _show({"then": then, "now": now}, {"then": bag, "now": out})


def resimulate_bag(bag: Path, choice: RepairChoice, from_time: float, out: Path) -> tuple[RunOutcome, RunOutcome]:
    """Drive a run again and record it; returns what it came to then and now.

    Raises:
        InputError: the bag, the choice, the moment or the place of the new bag is unusable, or the world differs from
            the recorded one.
        RecordingError: the new bag cannot be written.
        SimulationError: SUMO failed.
    """
    reader = BagReader(bag)
    plan, ticks = read_plan(reader), BagTicks(reader)
    then = recorded_outcome(ticks, plan.method)
    if not from_time <= then.duration:
        raise InputError("--from-time", f"{from_time:g} s is after the end", f"give 0 to {then.duration:g} s")
    switchover = Switchover(ticks, choice.make(), from_time)
    with new_bag(out) as writer, Console(stderr=True).status(f"{plan.scenario.name} · {choice.method}"):
        for attachment in reader.attachments.values():
            writer.add_attachment(attachment.name, attachment.media_type, attachment.data)
        methods = {False: plan.method, True: choice.method}
        recorder = EpisodeRecorder(writer, lambda time: methods[switchover.has_taken_over(time)], _map(reader))
        summary = run_episode(
            plan.scenario, make_policy(plan.policy), switchover, recorder.answered, recorder.ended, recorder.opened
        )
        now = driven_outcome(summary, choice.method)
        writer.add_metadata(
            RECORD,
            {
                "scenario_file": plan.scenario_file,
                "policy": plan.policy,
                **choice.provenance(),
                "roadmend": __version__,
                "resimulated_from": bag.name,
                "from_time": f"{from_time:g}",
                **account_of(summary, writer.count),
            },
        )
    return then, now


def _map(reader: BagReader) -> bytes | None:
    """The map as it was recorded: the world is the same."""
    kinds = reader.topics
    names = [name for name in kinds if kinds[name].type_name == "roadmend_msgs/msg/Map" and name.endswith("/map")]
    record = next(reader.records(names), None) if names else None
    return None if record is None else record.data


def _show(outcomes: dict[str, RunOutcome], bags: dict[str, Path]) -> None:
    table = Table(box=None, pad_edge=False, header_style="bold")
    for title in ("", "method", "outcome", "after"):
        table.add_column(title, no_wrap=True)
    for title in ("min\ndistance", "inter-\nventions"):
        table.add_column(title, justify="right", no_wrap=True)
    table.add_column("bag", overflow="fold")
    for when, one in outcomes.items():
        distance = "-" if one.min_distance is None else f"{one.min_distance:.2f} m"
        outcome = f"[{OUTCOME_STYLES.get(one.outcome, 'white')}]{one.outcome}[/]"
        after, bag = f"{one.duration:.2f} s", str(bags[when])
        table.add_row(when, one.method, outcome, after, distance, str(one.interventions), bag)
    wide_console().print(table)
