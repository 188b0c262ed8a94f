"""``roadmend bag info``: what a bag holds."""

import json
from pathlib import Path

import click
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from roadmend.cli.bag_progress import bag_progress
from roadmend.cli.table import wide_console
from roadmend.recording.info import BagInfo, TopicInfo
from roadmend.recording.info import bag_info as read_info
from roadmend.recording.recovery import bag_size


@click.command("info")
@click.argument("bag", type=click.Path(path_type=Path))
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def bag_info(bag: Path, *, as_json: bool) -> None:
    """Show a bag's topics, types, rates and gaps, its outcome and interventions, and whether it is complete.

    Reads all of the bag, so that what it says of damages holds. A gap is a silence of more than 2.5 times the usual
    interval, on topics that keep a rate.
    """
    with bag_progress("reading", bag_size(bag)) as advance:
        info = read_info(bag, advance)
    if as_json:
        click.echo(json.dumps(info.as_dict(), indent=2))
    else:
        _show(info, wide_console())


def _show(info: BagInfo, console: Console) -> None:
    span = "no messages" if info.start is None or info.end is None else f"{info.start:.3f} .. {info.end:.3f} s"
    table = Table.grid(padding=(0, 2))
    table.add_row("bag", escape(info.bag))
    table.add_row("files", f"{len(info.files)}, {info.bytes / 1e6:.2f} MB")
    table.add_row("messages", f"{info.messages}, {span}")
    table.add_row("complete", "[green]yes[/]" if info.complete else "[red]no[/]")
    for line in info.missing:
        table.add_row("", escape(line))
    if info.outcome:
        table.add_row("outcome", escape(f"{info.outcome} {info.outcome_text}".strip()))
    if info.interventions is not None:
        table.add_row("interventions", _interventions(info))
    for record in info.metadata.values():
        for name, value in record.items():
            if not name.startswith("outcome"):
                table.add_row(escape(name), escape(value))
    for name, size in info.attachments.items():
        table.add_row("attachment", escape(f"{name}, {size} bytes"))
    console.print(table)
    console.print(_topics(info.topics))


def _interventions(info: BagInfo) -> str:
    acts = info.interventions
    if acts is None:
        return ""
    states = ", ".join(f"{name} {count}" for name, count in acts.states.items())
    return f"{acts.interventions} of {acts.ticks} ticks in {acts.spells} spells ({states})"


def _topics(topics: list[TopicInfo]) -> Table:
    table = Table(box=None, pad_edge=False, header_style="bold")
    for title in ("topic", "type"):
        table.add_column(title, no_wrap=True)
    for title in ("messages", "rate", "gaps"):
        table.add_column(title, justify="right")
    table.add_column("longest gap", no_wrap=True)
    table.add_column("", no_wrap=True)
    for topic in topics:
        gap = "" if topic.longest_gap is None else f"{topic.longest_gap:.3f} s at {topic.longest_gap_at:.3f} s"
        notes = ["latched"] if topic.latched else []
        notes += [f"{topic.out_of_order} out of order"] if topic.out_of_order else []
        rate = "-" if topic.rate is None else f"{topic.rate:.2f}/s"
        gaps = "-" if topic.gaps is None else str(topic.gaps)
        table.add_row(topic.name, topic.type, str(topic.count), rate, gaps, gap, ", ".join(notes))
    return table
