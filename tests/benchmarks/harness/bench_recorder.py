"""``roadmend bench recorder``: what the recorder takes in beside the bare MCAP writer, and what a kill costs."""

import statistics
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click
from rich.console import Console
from rich.progress import Progress

from harness.bare_writing import time_bare_writing
from harness.figures import Figures
from harness.load import serialized_messages
from harness.recorder_trial import Killed, Load, Recorded, kill, moments, record
from roadmend.recording.bag_file import Compression
from roadmend.reports.result_files import provenance

_RATE = 2000.0  # messages a second
_KILL_SECONDS = 60.0  # [s] of load, longer than any kill waits


@click.command()
@click.option("--seconds", default=5, show_default=True, type=click.IntRange(1, 600), help="Length of a paced load.")
@click.option("--repeats", default=5, show_default=True, type=click.IntRange(1, 100), help="Recordings of each kind.")
@click.option("--kills", default=20, show_default=True, type=click.IntRange(1, 1000), help="Recordings to kill.")
@click.option("--size", default=20_000, show_default=True, type=click.IntRange(16, 10_000_000), help="Bytes a message.")
@click.option("--compression", default="zstd", show_default=True, type=click.Choice([one.value for one in Compression]))
@click.option("--out", type=click.Path(path_type=Path, file_okay=False), help="Folder for recorder.json and .md.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def recorder(
    seconds: int, repeats: int, kills: int, size: int, compression: str, out: Path | None, *, as_json: bool
) -> None:
    """Record 2,000 messages a second; as many as are taken, beside the bare MCAP writer; and kill the recorder.

    The messages are random bytes, which no compression makes smaller. Each kill (SIGKILL) comes at a random moment of a
    load of 2,000 messages a second, and the bag is recovered.
    """
    count = round(seconds * _RATE)
    paced, full, ratios, killed = [], [], [], []
    with (
        Progress(console=Console(stderr=True)) as progress,
        tempfile.TemporaryDirectory(prefix="roadmend-bench-") as place,
    ):
        task = progress.add_task("recorder", total=2 * repeats + kills)
        for repeat in range(repeats):
            with tempfile.TemporaryDirectory(dir=place) as folder:
                paced.append(record(Path(folder), Load(count, _RATE, size), compression))
            progress.advance(task)
            with tempfile.TemporaryDirectory(dir=place) as folder:
                bare = [_bare(Path(folder), count, size, compression)]
                full.append(record(Path(folder), Load(count, 0.0, size), compression))
                bare.append(_bare(Path(folder), count, size, compression))
                ratios.append(full[repeat].megabytes_per_second / statistics.fmean(bare))
            progress.advance(task)
        for after in moments(kills):
            with tempfile.TemporaryDirectory(dir=place) as folder:
                killed.append(kill(Path(folder), Load(round(_KILL_SECONDS * _RATE), _RATE, size), after))
            progress.advance(task)
    command = f"./roadmend bench recorder --seconds {seconds} --repeats {repeats} --kills {kills}"
    command += f" --size {size} --compression {compression}"
    content = {"provenance": provenance(command), "bytes": size, "compression": compression}
    content |= {
        "paced": _figures(paced),
        "full": _figures(full),
        "ratio_to_bare": _spread(ratios),
        "killed": _losses(killed),
    }
    Figures("recorder", "The recorder", content, _rows(content)).publish(out, as_json=as_json)


def _bare(folder: Path, count: int, size: int, compression: str) -> float:
    """Megabytes a second that the bare writer brings to the disk."""
    path = folder / "bare.mcap"
    seconds = time_bare_writing(path, serialized_messages(size), count, compression)
    written = path.stat().st_size / 1e6
    path.unlink()
    return written / seconds


def _figures(recorded: Sequence[Recorded]) -> dict[str, Any]:
    return {
        "published": sum(one.published for one in recorded),
        "dropped": sum(one.dropped for one in recorded),
        "offered_per_second": _spread([one.offered_rate for one in recorded]),
        "megabytes_per_second": _spread([one.megabytes_per_second for one in recorded]),
    }


def _losses(killed: Sequence[Killed]) -> dict[str, Any]:
    return {
        "recordings": len(killed),
        "recovered": sum(one.recovered > 0 for one in killed),
        "holes": sum(one.holes for one in killed),
        "lost_seconds": _spread([one.lost_seconds for one in killed]),
    }


def _spread(values: Sequence[float]) -> dict[str, float]:
    return {"median": statistics.median(values), "min": min(values), "max": max(values)}


def _rows(content: dict[str, Any]) -> list[list[str]]:
    def row(what: str, spread: dict[str, float], unit: str, note: str) -> list[str]:
        return [what, f"{spread['median']:.2f} {unit}", f"{spread['min']:.2f} .. {spread['max']:.2f}", note]

    paced, full, killed = content["paced"], content["full"], content["killed"]
    of_all = "{dropped} of {published} messages dropped".format
    return [
        ["what", "median", "spread", ""],
        row("2,000 messages a second, to the disk", paced["megabytes_per_second"], "MB/s", of_all(**paced)),
        row("as many as are taken, to the disk", full["megabytes_per_second"], "MB/s", of_all(**full)),
        row("the same / bare MCAP writer", content["ratio_to_bare"], "x", ""),
        row(
            "lost by SIGKILL under the first load",
            killed["lost_seconds"],
            "s",
            f"{killed['recovered']} of {killed['recordings']} bags recovered, {killed['holes']} messages missing before",
        ),
    ]
