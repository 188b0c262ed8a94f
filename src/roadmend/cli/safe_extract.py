"""``roadmend safe extract``: what happened in a crash, from its report."""

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import click
from rich.markup import escape
from rich.table import Table

from roadmend.cli.language_options import language_options
from roadmend.cli.options import WORKERS
from roadmend.cli.output import counting, wide_console
from roadmend.language.exchange import add_usages
from roadmend.safe.backends import BACKENDS, BackendOptions
from roadmend.safe.extraction_run import Extracted, extract_reports
from roadmend.safe.report import find_reports
from roadmend.safe.sketch_text import is_sketch_read
from roadmend.safe.stage_one import StageOneOptions


@click.command()
@click.argument("reports", type=click.Path(path_type=Path))
@click.option("--out", required=True, type=click.Path(path_type=Path, file_okay=False), help="Folder for the results.")
@language_options(BACKENDS)
@click.option("--no-prompt-generation", is_flag=True, help="With a model: ask without the knowledge base.")
@click.option("--no-validation", is_flag=True, help="With a model: take its answers unchecked.")
@WORKERS
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def extract(
    reports: Path,
    out: Path,
    backend: str,
    settings: Path | None,
    recording: Path | None,
    attempts: int,
    workers: int,
    *,
    no_prompt_generation: bool,
    no_validation: bool,
    as_json: bool,
) -> int:
    """Read a crash report, or a folder of them; exit code 1 if one of them gave no scenario.

    A report is a folder with summary.txt and perhaps a sketch (sketch.jpg, .png), or a text file. Reports that an
    earlier call with the same settings has done are not done again.
    """
    options = StageOneOptions(not no_prompt_generation, not no_validation, attempts)
    paths = find_reports(reports)
    extractor = BACKENDS[backend](BackendOptions(options, settings, recording))
    # What a model is, and that a sketch is read by a program that may be there or not.
    decided = [backend, str(options), str(is_sketch_read()), getattr(getattr(extractor, "model", None), "identity", "")]
    done = []
    with counting() as progress:
        task = progress.add_task("reports", total=len(paths))
        for extracted in extract_reports(paths, extractor, decided, out, workers):
            done.append(extracted)
            progress.advance(task)
    done.sort(key=lambda extracted: extracted.case)
    usage = add_usages(extracted.usage for extracted in done)
    if as_json:
        total = {model: asdict(usage) for model, usage in usage.items()}
        click.echo(json.dumps({"reports": [asdict(extracted) for extracted in done], "usage": total}, indent=2))
    else:
        _show(done, out)
        for model, used in usage.items():
            click.echo(f"{model}: {used}")
    return 1 if any(extracted.error for extracted in done) else 0


def _show(done: Sequence[Extracted], out: Path) -> None:
    table = Table(
        "report", "road", "lanes", "vehicles", "environment", "left open", box=None, pad_edge=False, header_style="bold"
    )
    for extracted in done:
        scenario = extracted.scenario
        if scenario is None:
            click.echo(extracted.error, err=True)
            continue
        vehicles = ", ".join(
            " ".join(str(vehicle[name] or "?") for name in ("model", "initial_position", "action"))
            for vehicle in scenario["vehicles"]
        )
        environment = " ".join(str(scenario["env"][name] or "?") for name in ("time", "weather"))
        road = " ".join(filter(None, (scenario["road_type"] or "?", scenario["stem_direction"])))
        lanes = str(scenario["num_lanes"] or "?")
        table.add_row(escape(extracted.case), road, lanes, vehicles, environment, str(len(extracted.open_fields)))
    wide_console().print(table)
    failed = sum(extracted.error is not None for extracted in done)
    known = sum(not extracted.is_new for extracted in done)
    click.echo(f"{len(done) - failed} of {len(done)} read ({known} by an earlier call), in {out}")
