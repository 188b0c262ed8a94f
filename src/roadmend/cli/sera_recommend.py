"""``roadmend sera recommend``: select scenarios to learn from, reflect on the selection, say why."""

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import click
from rich.table import Table

from roadmend.cli.language_options import language_options
from roadmend.cli.output import wide_console
from roadmend.cli.sera_language import keeping_exchanges, open_backend, show_usage
from roadmend.cli.sera_options import BANK, EMBEDDER, JSON, PATTERN, filter_options, filters_of
from roadmend.core.whole_file import write_text
from roadmend.sera.backends import BACKENDS
from roadmend.sera.bank import Bank
from roadmend.sera.pattern import read_patterns
from roadmend.sera.recommendation import content_of
from roadmend.sera.recommendation import recommend as recommend_from
from roadmend.world.scenario_file import load_scenario


@click.command()
@BANK
@EMBEDDER
@PATTERN
@click.option("-k", "count", default=8, show_default=True, type=click.IntRange(1, 1000), help="Scenarios a pattern.")
@click.option("--seed", default=0, show_default=True, type=click.IntRange(0), help="Of the random selection.")
@click.option(
    "--exclude",
    multiple=True,
    type=click.Path(path_type=Path, dir_okay=False),
    help="Scenario file that must not come, as one of the evaluation set. May be repeated.",
)
@language_options(BACKENDS)
@click.option(
    "--out",
    type=click.Path(path_type=Path, dir_okay=False),
    help="The selections as JSON; beside it what a language model was asked.",
)
@filter_options
@JSON
def recommend(
    bank_file: Path,
    embedder: str | None,
    patterns: tuple[str, ...],
    count: int,
    seed: int,
    exclude: tuple[Path, ...],
    backend: str,
    settings: Path | None,
    recording: Path | None,
    attempts: int,
    out: Path | None,
    *,
    as_json: bool,
    **given: tuple[str, ...],
) -> None:
    """Select the best scenarios for each failure pattern, and swap what the selection as a whole is better without."""
    wanted = [pattern for each in patterns for pattern in read_patterns(each)]
    digests = [load_scenario(path).digest for path in exclude]
    filters = filters_of(given)
    asked = open_backend(backend, settings, recording, attempts, out)
    with Bank(bank_file, embedder) as opened, keeping_exchanges(asked, out):
        found = recommend_from(opened, wanted, count, filters, digests, seed, asked.reflector)
        content = content_of(found, wanted, opened)
    content["usage"] = {model: asdict(used) for model, used in asked.usage().items()}
    text = json.dumps(content, indent=2)
    if out is not None:
        write_text(out, text + "\n")
    if as_json:
        click.echo(text)
    else:
        _show(content)
        show_usage(asked)


def _show(content: dict[str, Any]) -> None:
    console = wide_console()
    table = Table("pattern", "score", "name", "words", box=None, pad_edge=False, header_style="bold")
    for each in content["refined"]:
        table.add_row(each["pattern"], f"{each['score']:.3f}", each["name"], each["words"])
    console.print(table)
    for swap in content["swaps"]:
        console.print(f"{swap['out']} -> {swap['into']}: {swap['reason']}")
    measures = Table("selection", *content["measures"]["initial"], box=None, pad_edge=False, header_style="bold")
    for name, values in content["measures"].items():
        measures.add_row(
            name, *(f"{value:.3f}" if isinstance(value, float) else str(value) for value in values.values())
        )
    console.print(measures)
    if content["missing"]:
        console.print(f"{content['missing']} places stay empty: the bank has no more that pass")
