"""``roadmend bench texts``: how much of made-up crash texts is read right, by who wrote them and whether rules were made from them."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import click

from harness.crash_reading import read_crashes
from harness.figures import Figures
from harness.safe_extraction import measure_registers
from harness.safe_rows import SURE, right_of
from harness.scoring import load_oracles, majority, score
from roadmend.cli.options import JSON, WORKERS
from roadmend.cli.output import counting
from roadmend.core.errors import InputError
from roadmend.measures.intervals import wilson
from roadmend.reports.result_files import provenance
from roadmend.world.network import cache_folder

_TEXTS = Path(__file__).parents[1] / "crash_texts"
_FITTED = "developed"  # the set that rules were made from


@click.command()
@click.argument("folder", default=_TEXTS, type=click.Path(path_type=Path, exists=True, file_okay=False))
@click.option("--out", type=click.Path(path_type=Path, file_okay=False), help="Folder for texts.json and texts.md.")
@WORKERS
@JSON
def texts(folder: Path, out: Path | None, workers: int, *, as_json: bool) -> None:
    """Read the texts of FOLDER (SET-NAME.txt with SET-NAME.oracle.json; the committed ones by default), and score each set.

    Beside each stands a reader that gives the usual value of every field. Only totals are printed.
    """
    paths = sorted(folder.glob("*-*.txt"))
    oracles = load_oracles(folder)
    paths = [path for path in paths if path.stem in oracles]
    if not paths:
        raise InputError(str(folder), "holds no text with an oracle", "give SET-NAME.txt beside SET-NAME.oracle.json")
    with counting() as progress:
        task = progress.add_task("reading", total=len(paths))
        read = read_crashes(
            paths,
            cache_folder() / "benchmarks" / "texts",
            workers,
            lambda done: progress.update(task, completed=done),
            sketch=False,
        )
    sets = dict.fromkeys(path.stem.partition("-")[0] for path in paths)
    fitted = [oracle for name, oracle in oracles.items() if name.startswith(f"{_FITTED}-")] or [*oracles.values()]
    usual = majority(fitted)
    found: dict[str, Any] = {}
    for name in sets:
        mine = [each for each in read if each.name.startswith(f"{name}-")]
        trivial = score({each.name: usual for each in mine}, oracles, text_only=True)
        assert trivial is not None
        found[name] = {**(measure_registers(mine, folder) or {}), "majority": asdict(trivial)}
    command = "./roadmend bench texts" + ("" if folder == _TEXTS else f" {folder}")
    content = {"format": "roadmend-texts/1", "provenance": provenance(command), "sets": found}
    Figures("texts", "Crash texts in other registers", content, _rows(found)).publish(out, as_json=as_json)


def _rows(sets: Mapping[str, Mapping[str, Any]]) -> Sequence[Sequence[str]]:
    rows = [
        [
            "set",
            "texts",
            "road",
            "actors",
            "environment",
            "overall",
            "95 %",
            "usual values",
            f"right, of fields given with {SURE} or more",
        ]
    ]
    for name, found in sets.items():
        cases = found["cases"]
        low, high = (100 * side for side in wilson(round(found["overall"] * cases / 100), cases))
        shares = [f"{found[key]:.1f}" for key in ("road", "actors", "env", "overall")]
        surest = next(each for each in found["calibration"] if each["low"] == SURE)
        right = right_of(surest)
        rows.append(
            [name, str(cases), *shares, f"{low:.1f} .. {high:.1f}", f"{found['majority']['overall']:.1f}", right]
        )
    return rows
