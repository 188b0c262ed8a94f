"""``roadmend sera analyse``: the failures in bags, and the patterns in them."""

import json
from dataclasses import asdict
from pathlib import Path

import click

from roadmend.cli.language_options import language_options
from roadmend.cli.options import WORKERS
from roadmend.cli.output import counting, show_rows
from roadmend.cli.sera_language import keeping_exchanges, open_backend, show_usage
from roadmend.core.errors import InputError
from roadmend.core.fanout import fan_out
from roadmend.core.whole_file import write_text
from roadmend.sera.analysis import Analysis, analyse, find_bags, read_incidents
from roadmend.sera.analysis_report import NOTHING, pattern_rows, report
from roadmend.sera.backends import BACKENDS
from roadmend.sera.pattern import dump_patterns


@click.command("analyse")
@click.argument("bags", nargs=-1, required=True, type=click.Path(path_type=Path))
@language_options(BACKENDS)
@click.option(
    "--out",
    type=click.Path(path_type=Path, dir_okay=False),
    help="The patterns for 'sera recommend', JSON; a report as .md beside it, and what a language model was asked.",
)
@WORKERS
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def analyse_bags(
    bags: tuple[Path, ...],
    backend: str,
    settings: Path | None,
    recording: Path | None,
    attempts: int,
    out: Path | None,
    workers: int,
    *,
    as_json: bool,
) -> int:
    """Find the failures and interventions in BAGS, and the patterns in them.

    BAGS are bags, or folders with bags in them. A bag that cannot be read is named, and the others go on; the exit code
    is then 1.
    """
    found = find_bags(bags)
    if out is not None and out.suffix == ".md":
        raise InputError("--out", f"{out} is where the report would go", "name a .json file")
    opened = open_backend(backend, settings, recording, attempts, out)
    readings = []
    with (
        fan_out(workers, len(found)) as mapper,
        counting(is_transient=True) as progress,
    ):
        task = progress.add_task("bags", total=len(found))
        for reading in mapper(read_incidents, found):
            readings.append(reading)
            progress.advance(task)
    with keeping_exchanges(opened, out):
        analysis = analyse(readings, opened.analyser)
    if out is not None:
        write_text(out, dump_patterns(analysis.patterns))
        write_text(out.with_suffix(".md"), report(analysis))
    if as_json:
        click.echo(
            json.dumps(
                {**asdict(analysis), "usage": {model: asdict(used) for model, used in opened.usage().items()}},
                indent=2,
                allow_nan=False,
            )
        )
    else:
        _show(analysis)
        show_usage(opened)
    for each in analysis.unreadable:
        click.echo(f"not read: {each.problem}", err=True)
    return 1 if analysis.unreadable else 0


def _show(analysis: Analysis) -> None:
    if not analysis.patterns:
        click.echo(NOTHING if analysis.bags else "No bag could be read.")
        return
    show_rows(pattern_rows(analysis))
