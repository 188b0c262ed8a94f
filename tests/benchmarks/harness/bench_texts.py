"""``roadmend bench texts``: how much of made-up crash texts is read right, by who wrote them and whether rules were made from them."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import click

from harness.crash_reading import ReadCrash, read_crashes
from harness.figures import Figures
from harness.safe_extraction import measure_registers
from harness.safe_rows import SURE, right_of
from harness.scoring import ORACLE, load_oracles, majority, score
from roadmend.cli.options import JSON, WORKERS
from roadmend.cli.output import counting
from roadmend.core.errors import InputError
from roadmend.core.resources import cache_folder, config_folder
from roadmend.core.whole_file import write_texts
from roadmend.measures.intervals import wilson
from roadmend.networks.checkpoint import find_model, load_checkpoint
from roadmend.reports.result_files import provenance
from roadmend.safe.trained.crash_network import KIND
from roadmend.safe.trained.told_crashes import read_told
from roadmend.safe.trained.trained_claims import SHIPPED

_TEXTS = Path(__file__).parents[1] / "crash_texts"
_FITTED = "developed"  # the set that rules were made from
_HELD_OUT = "held_out"


@click.command()
@click.argument("folder", required=False, type=click.Path(path_type=Path, exists=True, file_okay=False))
@click.option("--out", type=click.Path(path_type=Path, file_okay=False), help="Folder for texts.json and texts.md.")
@WORKERS
@JSON
def texts(folder: Path | None, out: Path | None, workers: int, *, as_json: bool) -> None:
    """Read the texts of FOLDER (SET-NAME.txt with SET-NAME.oracle.json), and score each set.

    The committed ones by default, and the told crashes by authors of whom the trained reader learned nothing. Beside each
    set stand the rules without the trained reader, and a reader that gives the usual value of every field. Only totals
    are printed.
    """
    work = cache_folder() / "benchmarks" / "texts"
    folders = [_TEXTS, _held_out(work / _HELD_OUT)] if folder is None else [folder]
    oracles = {name: oracle for each in folders for name, oracle in load_oracles(each).items()}
    paths = [path for each in folders for path in sorted(each.glob("*-*.txt")) if path.stem in oracles]
    if not paths:
        raise InputError(str(folder), "holds no text with an oracle", "give SET-NAME.txt beside SET-NAME.oracle.json")
    read, bare = (_read(paths, work, workers, trained=trained) for trained in (True, False))
    fitted = [oracle for name, oracle in oracles.items() if name.startswith(f"{_FITTED}-")] or [*oracles.values()]
    usual = majority(fitted)
    found: dict[str, Any] = {}
    for name in dict.fromkeys(path.stem.partition("-")[0] for path in paths):
        mine, alone = ([each for each in of if each.name.startswith(f"{name}-")] for of in (read, bare))
        trivial = score({each.name: usual for each in mine}, oracles, text_only=True)
        assert trivial is not None
        found[name] = {
            **(measure_registers(mine, oracles) or {}),
            "without_trained_reader": measure_registers(alone, oracles),
            "majority": asdict(trivial),
        }
    command = "./roadmend bench texts" + ("" if folder is None else f" {folder}")
    content = {"format": "roadmend-texts/1", "provenance": provenance(command), "sets": found}
    Figures("texts", "Crash texts in other registers", content, _rows(found)).publish(out, as_json=as_json)


def _read(paths: Sequence[Path], work: Path, workers: int, *, trained: bool) -> list[ReadCrash]:
    with counting() as progress:
        task = progress.add_task("reading" if trained else "reading, rules alone", total=len(paths))
        return read_crashes(
            paths, work, workers, lambda done: progress.update(task, completed=done), sketch=False, trained=trained
        )


def _held_out(folder: Path) -> Path:
    """A folder with the told crashes that the shipped reader was only measured on, as texts with oracles."""
    authors = load_checkpoint(find_model(SHIPPED), KIND).header["configuration"]["held_out"]
    files = dict[str, str]()
    for crash in read_told(config_folder() / "crashes" / "told-crashes.jsonl"):
        if crash.author in authors:
            name = f"{_HELD_OUT}-{crash.author}-{crash.name}"
            files |= {f"{name}.txt": crash.text, f"{name}.{ORACLE}": json.dumps(crash.key)}
    write_texts(folder, files)
    for path in folder.iterdir():  # of other authors, whom an earlier model was measured on
        if path.name not in files:
            path.unlink()
    return folder


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
            "without the trained reader",
            "usual values",
            f"right, of fields given with {SURE} or more",
            "filled, of fields that the key leaves open",
        ]
    ]
    for name, found in sets.items():
        cases = found["cases"]
        low, high = (100 * side for side in wilson(round(found["overall"] * cases / 100), cases))
        shares = [f"{found[key]:.1f}" for key in ("road", "actors", "env", "overall")]
        surest = next(each for each in found["calibration"] if each["low"] == SURE)
        right = right_of(surest)
        alone, usual = (f"{found[control]['overall']:.1f}" for control in ("without_trained_reader", "majority"))
        filled, bare = (of["left_open"] for of in (found, found["without_trained_reader"]))
        invented = f"{filled['filled']} of {filled['fields']}, {bare['filled']} without the trained reader"
        interval = f"{low:.1f} .. {high:.1f}"
        rows.append([name.replace("_", " "), str(cases), *shares, interval, alone, usual, right, invented])
    return rows
