"""``roadmend bag``: what was recorded, looked into, mended, converted and compared."""

import json
import math
from dataclasses import asdict, replace
from pathlib import Path

import click
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from roadmend.cli.command import ExampleCommand
from roadmend.cli.driver_options import DROVE
from roadmend.cli.options import FUTURES, JSON, PATH
from roadmend.cli.output import bag_progress, message_progress, wide_console
from roadmend.cli.spell_table import account_figures, show_spells
from roadmend.core.spell import Spell
from roadmend.core.spell_account import with_needs
from roadmend.recording.conversion import MCAP, SQLITE3, convert, storage_of
from roadmend.recording.diff import UNSTEADY, BagDiff, TopicDiff
from roadmend.recording.diff import bag_diff as compare
from roadmend.recording.info import BagInfo, TopicInfo
from roadmend.recording.info import bag_info as read_info
from roadmend.recording.recovery import bag_size, recover

_LONGEST = 600  # characters of a record that people are shown


@click.command(
    "info", cls=ExampleCommand, examples=["roadmend bag info bags/my-run", "roadmend bag info bags/my-run --json"]
)
@click.argument("bag", type=PATH)
@FUTURES
@DROVE
@JSON
def bag_info(bag: Path, futures: int, policy: str, *, as_json: bool) -> None:
    """Show a bag's topics, types, rates and gaps, its outcome and interventions, and whether it is complete.

    Reads all of the bag, so that what it says of damages holds. A gap is a silence of more than 2.5 times the usual
    interval, on topics that keep a rate. Of each intervention it tells what it was worth in the method's own judgement
    (in prices of a collision), because of whom and why; and with --futures, from the run driven again, whether it was
    needed.
    """
    with bag_progress("reading", bag_size(bag)) as advance:
        info = read_info(bag, advance)
    if futures:
        info = replace(info, spells=with_needs(info.spells, _with_need(bag, futures, policy)))
    if as_json:
        spells = [account_figures(account) for account in info.spells]
        click.echo(json.dumps(info.as_dict() | {"spells": spells}, indent=2))
    else:
        _show_info(info, wide_console())


def _with_need(bag: Path, futures: int, policy: str) -> tuple[Spell, ...]:
    from roadmend.cli.bag_need import needs_of  # noqa: PLC0415 - SUMO and the policies; most calls drive nothing

    return needs_of(bag, futures, policy)


def _show_info(info: BagInfo, console: Console) -> None:
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
                table.add_row(escape(name), escape(_short(value)))
    for name, size in info.attachments.items():
        table.add_row("attachment", escape(f"{name}, {size} bytes"))
    console.print(table)
    if info.spells:
        console.print()
        show_spells(info.spells, console)
        console.print()
    console.print(_topic_table(info.topics))


def _short(value: str) -> str:
    """What a record says, for people; long ones, such as what every node has announced, are for programs."""
    return value if len(value) <= _LONGEST else f"{len(value)} characters, told whole by --json"


def _apart(*values: str) -> list[str]:
    """What two records say, without what both say alike, where they are objects of JSON."""
    try:
        objects = [json.loads(value) for value in values]
    except ValueError:
        return [*values]
    if not all(isinstance(each, dict) for each in objects):
        return [*values]
    alike = {key for key in objects[0] if objects[0][key] == objects[1].get(key, ...)}
    return [json.dumps({key: value for key, value in each.items() if key not in alike}) for each in objects]


def _interventions(info: BagInfo) -> str:
    acts = info.interventions
    if acts is None:
        return ""
    states = ", ".join(f"{name} {count}" for name, count in acts.states.items())
    return f"{acts.interventions} of {acts.ticks} ticks in {acts.spells} spells ({states})"


def _topic_table(topics: list[TopicInfo]) -> Table:
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
        table.add_row(escape(topic.name), escape(topic.type), str(topic.count), rate, gaps, gap, ", ".join(notes))
    return table


@click.command("recover", cls=ExampleCommand, examples=["roadmend bag recover bags/cut-run --out bags/mended"])
@click.argument("bag", type=PATH)
@click.option("--out", type=PATH, help="Folder of the new bag.  [default: NAME-recovered]")
@JSON
def bag_recover(bag: Path, out: Path | None, *, as_json: bool) -> None:
    """Bring back every whole message of a bag that was cut or damaged, and say what is missing.

    BAG itself stays as it is. A recording that was killed lacks metadata.yaml and an index; a file may also be cut in
    the middle of a message, or have damaged places.
    """
    target = out or Path(f"{_name(bag)}-recovered")
    with bag_progress("recovering", bag_size(bag)) as advance:
        recovery = recover(bag, target, advance)
    if as_json:
        click.echo(json.dumps(asdict(recovery), indent=2))
        return
    click.echo(f"{recovery.bag}: {recovery.count} messages of {len(recovery.messages)} topics")
    for line in recovery.missing:
        click.echo(f"missing: {line}")
    if not recovery.missing:
        click.echo("nothing is missing: the bag was whole")


_FIELDS_SHOWN = 3


@click.command("diff", cls=ExampleCommand, examples=["roadmend bag diff bags/one bags/other --topics '^/(ego|policy)'"])
@click.argument("first", type=PATH)
@click.argument("second", type=PATH)
@click.option("--topics", default="", help="Regular expression found in each topic to compare.")
@click.option("--exclude", default=UNSTEADY, show_default=True, help="The same for topics not to compare.")
@JSON
def bag_diff(first: Path, second: Path, topics: str, exclude: str, *, as_json: bool) -> int:
    """Compare two bags tick by tick: the first differing tick, how far, and how far apart the vehicle was.

    Compares decoded values. Left out by default is what depends on the machine: diagnostics, drawings, and the nodes' parameters.
    Ends with 0 where the bags are equal, with 1 where they differ, with 2 where one cannot be read.
    """
    with message_progress("comparing") as advance:
        diff = compare(first, second, topics, exclude, advance)
    if as_json:
        click.echo(json.dumps(diff.as_dict(), indent=2))
    else:
        _show_diff(diff, wide_console())
    return 0 if diff.is_equal else 1


def _show_diff(diff: BagDiff, console: Console) -> None:
    if diff.is_equal:
        console.print(f"equal: {diff.ticks} ticks of {len(diff.topics)} topics")
    elif diff.first_difference is not None:
        start = f"first at {diff.first_difference:.3f} s"
        console.print(f"different: {diff.differing_ticks} of {diff.ticks} ticks, {start}")
    for name, (one, other) in diff.types.items():
        console.print(escape(f"different: {name} holds {one} and {other}"))
    for path in diff.trajectories.values():
        far = (
            f"at most {path.largest:.4g} m (at {path.largest_at:.3f} s), mean {path.mean:.4g} m, last {path.last:.4g} m"
        )
        console.print(escape(f"distance of {path.topic}: {far}, over {path.ticks} ticks"))
    for key, (left, right) in diff.metadata.items():
        told = [_short(each or "-") for each in _apart(left, right)]
        console.print(escape(f"metadata {key}: {told[0]} and {told[1]}"))
    differing = [topic for topic in diff.topics.values() if topic.differing]
    if differing:
        console.print(_difference_table(differing))


def _difference_table(topics: list[TopicDiff]) -> Table:
    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("topic", no_wrap=True)
    for title in ("messages", "differing", "first"):
        table.add_column(title, justify="right", no_wrap=True)
    table.add_column("largest deviations")
    for topic in topics:
        largest = sorted(topic.largest.items(), key=lambda one: -one[1])
        shown = [f"{name} {'differs' if math.isinf(size) else f'{size:.4g}'}" for name, size in largest[:_FIELDS_SHOWN]]
        shown += [f"{len(largest) - _FIELDS_SHOWN} more fields"] if len(largest) > _FIELDS_SHOWN else []
        counts = {topic.first_messages, topic.second_messages}
        messages = (
            str(topic.first_messages) if len(counts) == 1 else f"{topic.first_messages} / {topic.second_messages}"
        )
        start = "" if topic.first_difference is None else f"{topic.first_difference:.3f} s"
        table.add_row(escape(topic.name), messages, str(topic.differing), start, escape(", ".join(shown)))
    return table


@click.command(
    "convert", cls=ExampleCommand, examples=["roadmend bag convert bags/my-run --to sqlite3 --out bags/my-run-sqlite3"]
)
@click.argument("bag", type=PATH)
@click.option("--to", "storage", type=click.Choice([MCAP, SQLITE3]), help="Storage.  [default: the other one]")
@click.option("--out", type=PATH, help="Folder of the new bag.  [default: NAME-STORAGE]")
@JSON
def bag_convert(bag: Path, storage: str | None, out: Path | None, *, as_json: bool) -> None:
    """Turn a bag of mcap into one of sqlite3, or the other way round.

    Topics, types, definitions, quality of service, times and bytes stay as they are. BAG itself is not touched.
    """
    target = storage or (SQLITE3 if storage_of(bag) == MCAP else MCAP)
    place = out or Path(f"{_name(bag)}-{target}")
    with message_progress("converting") as advance:
        conversion = convert(bag, place, target, advance)
    if as_json:
        click.echo(json.dumps(asdict(conversion), indent=2))
        return
    click.echo(f"{conversion.bag}: {conversion.messages} messages in {conversion.storage}")
    for line in conversion.left_out:
        click.echo(f"left out: {line}")


def _name(bag: Path) -> str:
    """What a bag is called, by its folder, its metadata.yaml or its .mcap."""
    path = bag.resolve()
    if path.name == "metadata.yaml":
        return path.parent.name
    return path.name if path.is_dir() else path.stem  # names of folders may have points
