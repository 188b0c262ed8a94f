"""``roadmend bag shadow``: another repair method on a recorded run, open loop."""

import json
from dataclasses import asdict
from pathlib import Path

import click
from rich.console import Console
from rich.table import Table

from roadmend.cli.repair_choice import RepairChoice, read_choice, repair_options
from roadmend.cli.table import wide_console
from roadmend.core.errors import InputError
from roadmend.core.repair import Repair
from roadmend.nodes.episode_writer import EpisodeWriter
from roadmend.recording.new_bag import BagCopy, new_bag
from roadmend.recording.reader import BagReader
from roadmend.recording.shadow import ShadowSummary, run_shadow
from roadmend.recording.ticks import BagTick, BagTicks

RECORD = "roadmend_shadow"  # metadata record


@click.command()
@click.argument("bag", type=click.Path(path_type=Path))
@repair_options
@click.option("--out", required=True, type=click.Path(path_type=Path), help="Folder of the new bag.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def shadow(
    bag: Path, method: str, settings: tuple[str, ...], model: Path | None, seed: int, out: Path, *, as_json: bool
) -> None:
    """Ask another repair method what it would have done at every tick of a recorded run.

    The new bag holds the recorded topics as they are, and the other method's answers as /shadow/repair/state and
    /shadow/repair/command.
    """
    choice = read_choice(method, settings, model, seed)
    summary = shadow_bag(bag, choice, out)
    if as_json:
        click.echo(json.dumps({**choice.provenance(), **asdict(summary), "bag": str(out)}, indent=2))
    else:
        _show(summary, choice, out)


def shadow_bag(bag: Path, choice: RepairChoice, out: Path) -> ShadowSummary:
    """Write what a method would have done beside what was done.

    Raises:
        InputError: the bag, the choice or the place of the new bag is unusable.
        RecordingError: the new bag cannot be written.
    """
    reader = BagReader(bag)
    ticks = BagTicks(reader)
    namespace = f"{ticks.namespace}/shadow"
    if any(name.startswith(f"{namespace}/") for name in reader.topics):
        raise InputError(str(bag), "has a shadow already", "take the bag that it was made of")
    repairer = choice.make()
    status = Console(stderr=True).status(f"{bag.name} · {choice.method}")
    with new_bag(out) as writer, status:
        copy, episode = BagCopy(reader, writer), EpisodeWriter(writer, namespace)

        def write(tick: BagTick, repair: Repair) -> None:
            copy.until(tick.stamp)
            episode.repair(tick.stamp * 1e-9, repair, choice.method)
            status.update(f"{bag.name} · {choice.method}: {tick.stamp * 1e-9:.0f} s")

        summary = run_shadow(ticks, repairer, write)
        copy.until(float("inf"))
        writer.add_metadata(RECORD, choice.provenance() | {"summary": json.dumps(asdict(summary))})
    return summary


def _show(summary: ShadowSummary, choice: RepairChoice, out: Path) -> None:
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
        str(summary.interventions_then),
        str(summary.interventions_now),
        f"{100.0 * summary.agreement:.1f} %",
        "-" if first is None else f"{first:.2f} s",
        f"{summary.acceleration_difference:.3f} m/s²",
        str(out),
    )
    wide_console().print(table)
