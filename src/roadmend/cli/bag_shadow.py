"""``roadmend bag shadow``: what another repair method would have done, in a bag of ours or of another stack."""

import json
from dataclasses import asdict
from pathlib import Path

import click
from rich.markup import escape
from rich.table import Table

from roadmend.cli.bag_repair import RepairChoice, RepairOptions, driver_of, read_choice, tell_choice
from roadmend.cli.command import ExampleCommand
from roadmend.cli.foreign_bag_options import ForeignBagOptions
from roadmend.cli.options import JSON, PATH, options_of
from roadmend.cli.output import Waiting, wide_console
from roadmend.core.errors import InputError
from roadmend.core.repair import Repair
from roadmend.recording.episode_writer import EpisodeWriter
from roadmend.recording.foreign_repair import Answer
from roadmend.recording.foreign_shadow import ForeignTopics, run_foreign_shadow
from roadmend.recording.new_bag import BagCopy, new_bag
from roadmend.recording.reader import BagReader
from roadmend.recording.shadow import ShadowSummary, run_shadow
from roadmend.recording.ticks import BagTick, BagTicks
from roadmend.recording.topics import SHADOW

SHADOW_RECORD = "roadmend_shadow"  # metadata record


@click.command(
    cls=ExampleCommand,
    examples=[
        "roadmend bag shadow bags/my-run --repair rss --set rho=0.4 --out bags/my-run-rss",
        "roadmend bag shadow theirs --ego /odom --objects /detections --command /drive/accel --repair rss --out shadow",
    ],
)
@click.argument("bag", type=PATH)
@options_of(RepairOptions)
@options_of(ForeignBagOptions, "foreign")
@click.option("--out", required=True, type=PATH, help="Folder of the new bag.")
@JSON
def shadow(bag: Path, given: RepairOptions, foreign: ForeignBagOptions, out: Path, *, as_json: bool) -> None:
    """Ask another repair method what it would have done at every tick of a recorded run.

    The new bag holds the recorded topics as they are, and the other method's answers as /shadow/repair/state and
    /shadow/repair/command. Of a bag that another stack recorded, name the topics.
    """
    driver = driver_of(bag)
    choice = read_choice(given, driver)
    if foreign.topics is None:
        summary = shadow_bag(bag, choice, out)
    else:
        choice = choice.braking(foreign.full_brake)
        summary = shadow_foreign_bag(bag, choice, foreign.topics, foreign, out)
    tell_choice(given, choice, driver)
    if summary.not_asked:
        told = f"{summary.not_asked} of {summary.ticks} answers are not its own, first at {summary.not_asked_why}"
        click.echo(f"{choice.method}: {told}", err=True)
    if as_json:
        click.echo(json.dumps({**choice.provenance(), **asdict(summary), "bag": str(out)}, indent=2))
    else:
        _show_shadow(summary, choice, out)


def shadow_bag(bag: Path, choice: RepairChoice, out: Path) -> ShadowSummary:
    """Write what a method would have done beside what was done.

    Raises:
        InputError: the bag, the choice or the place of the new bag is unusable.
        RecordingError: the new bag cannot be written.
    """
    reader = BagReader(bag)
    try:
        ticks = BagTicks(reader)
    except InputError as error:
        mend = f"{error.mend}, or name the topics of another stack's bag with --ego, --objects and --command"
        raise InputError(error.where, error.what, mend) from None
    namespace = f"{ticks.namespace}/{SHADOW}"
    if any(name.startswith(f"{namespace}/") for name in reader.topics):
        raise InputError(str(bag), "has a shadow already", "take the bag that it was made of")
    repairer = choice.make()
    with new_bag(out) as writer, Waiting(f"{bag.name} · {choice.method}") as waiting:
        copy, episode = BagCopy(reader, writer), EpisodeWriter(writer, namespace)

        def write(tick: BagTick, repair: Repair) -> None:
            copy.until(tick.time_ns)
            episode.answer(tick.time_ns, tick.stamp, repair, choice.method)
            waiting.update(f"{tick.stamp * 1e-9:.0f} s")

        summary = run_shadow(ticks, repairer, write)
        copy.until(float("inf"))
        writer.add_metadata(SHADOW_RECORD, choice.provenance() | {"summary": json.dumps(asdict(summary))})
    return summary


def shadow_foreign_bag(
    bag: Path, choice: RepairChoice, topics_: ForeignTopics, given: ForeignBagOptions, out: Path
) -> ShadowSummary:
    """Write what a method would have done into a copy of a bag that another stack recorded.

    Raises:
        InputError: the bag, a topic, the choice or the place of the new bag is unusable.
        RecordingError: the new bag cannot be written.
    """
    reader = BagReader(bag)
    topics_.by_input(reader)
    if any(name.startswith(f"/{SHADOW}/") for name in reader.topics):
        raise InputError(str(bag), "has a shadow already", "take the bag that it was made of")
    repairer = choice.make(full_brake=given.full_brake)
    with new_bag(out) as writer, Waiting(f"{bag.name} · {choice.method}"):
        copy, episode = BagCopy(reader, writer), EpisodeWriter(writer, f"/{SHADOW}")

        def write(time_ns: int, answer: Answer) -> None:
            copy.until(time_ns)
            episode.answer(time_ns, answer.stamp, answer.repair, choice.method)

        summary = run_foreign_shadow(reader, topics_, repairer, given.vehicle, given.pedals, write, given.input_timeout)
        copy.until(float("inf"))
        told = {"topics": json.dumps(asdict(topics_)), "summary": json.dumps(asdict(summary))}
        writer.add_metadata(SHADOW_RECORD, choice.provenance() | told)
    return summary


def _show_shadow(summary: ShadowSummary, choice: RepairChoice, out: Path) -> None:
    first = summary.first_difference
    table = Table(box=None, pad_edge=False, header_style="bold")
    for title in (
        "ticks",
        "interventions\nthen",
        f"interventions\nof {choice.method}",
        "agreement",
        "first\ndifference",
        "mean difference\nof acceleration",
    ):
        table.add_column(title, justify="right", no_wrap=True)
    table.add_column("bag", overflow="fold")
    table.add_row(
        str(summary.ticks),
        "-" if summary.interventions_then is None else str(summary.interventions_then),
        str(summary.interventions_now),
        f"{100.0 * summary.agreement:.1f} %",
        "-" if first is None else f"{first:.2f} s",
        f"{summary.acceleration_difference:.3f} m/s²",
        escape(str(out)),
    )
    wide_console().print(table)
