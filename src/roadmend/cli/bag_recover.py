"""``roadmend bag recover``: what a cut or damaged bag still holds, as a new bag."""

import json
from dataclasses import asdict
from pathlib import Path

import click

from roadmend.cli.bag_progress import bag_progress
from roadmend.recording.recovery import bag_size, recover


@click.command("recover")
@click.argument("bag", type=click.Path(path_type=Path))
@click.option("--out", type=click.Path(path_type=Path), help="Folder of the new bag.  [default: NAME-recovered]")
@click.option("--json", "as_json", is_flag=True, help="Print the result as JSON.")
def bag_recover(bag: Path, out: Path | None, *, as_json: bool) -> None:
    """Bring back every whole message of a bag that was cut or damaged, and say what is missing.

    BAG itself stays as it is. A recording that was killed lacks metadata.yaml and an index; a file may also be cut in
    the middle of a message, or have damaged places.
    """
    name = bag.resolve().parent.name if bag.name == "metadata.yaml" else bag.resolve().stem
    target = out or Path(f"{name}-recovered")
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
