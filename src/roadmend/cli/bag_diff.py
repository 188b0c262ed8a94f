"""``roadmend bag diff``: two bags held against each other."""

import json
import math
from pathlib import Path

import click
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from roadmend.cli.bag_progress import message_progress
from roadmend.cli.table import wide_console
from roadmend.recording.diff import UNSTEADY, BagDiff, TopicDiff
from roadmend.recording.diff import bag_diff as compare

_FIELDS_SHOWN = 3


@click.command("diff")
@click.argument("first", type=click.Path(path_type=Path))
@click.argument("second", type=click.Path(path_type=Path))
@click.option("--topics", default="", help="Regular expression found in each topic to compare.")
@click.option("--exclude", default=UNSTEADY, show_default=True, help="The same for topics not to compare.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def bag_diff(first: Path, second: Path, topics: str, exclude: str, *, as_json: bool) -> int:
    """Compare two bags tick by tick: the first differing tick, how far, and how far apart the vehicle was.

    Compares decoded values. Left out by default is what depends on the speed of the machine: diagnostics and drawings.
    Ends with 0 where the bags are equal, with 1 where they differ, with 2 where one cannot be read.
    """
    with message_progress("comparing") as advance:
        diff = compare(first, second, topics, exclude, advance)
    if as_json:
        click.echo(json.dumps(diff.as_dict(), indent=2))
    else:
        _show(diff, wide_console())
    return 0 if diff.is_equal else 1


def _show(diff: BagDiff, console: Console) -> None:
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
        console.print(escape(f"metadata {key}: {left or '-'} and {right or '-'}"))
    differing = [topic for topic in diff.topics.values() if topic.differing]
    if differing:
        console.print(_topics(differing))


def _topics(topics: list[TopicDiff]) -> Table:
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
        table.add_row(topic.name, messages, str(topic.differing), start, escape(", ".join(shown)))
    return table
