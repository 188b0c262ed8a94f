"""``roadmend bag convert``: from mcap to sqlite3 and back."""

from pathlib import Path

import click

from roadmend.cli.bag_progress import message_progress
from roadmend.recording.conversion import MCAP, SQLITE3, convert, storage_of


@click.command("convert")
@click.argument("bag", type=click.Path(path_type=Path))
@click.option("--to", "storage", type=click.Choice([MCAP, SQLITE3]), help="Storage.  [default: the other one]")
@click.option("--out", type=click.Path(path_type=Path), help="Folder of the new bag.  [default: NAME-STORAGE]")
def bag_convert(bag: Path, storage: str | None, out: Path | None) -> None:
    """Turn a bag of mcap into one of sqlite3, or the other way round.

    Topics, types, definitions, quality of service, times and bytes stay as they are. BAG itself is not touched.
    """
    target = storage or (SQLITE3 if storage_of(bag) == MCAP else MCAP)
    place = out or Path(f"{_name(bag)}-{target}")
    with message_progress("converting") as advance:
        conversion = convert(bag, place, target, advance)
    click.echo(f"{conversion.bag}: {conversion.messages} messages in {conversion.storage}")
    for line in conversion.left_out:
        click.echo(f"left out: {line}")


def _name(bag: Path) -> str:
    path = bag.resolve()
    return path.parent.name if path.name == "metadata.yaml" else path.stem
