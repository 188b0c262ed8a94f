"""``roadmend sera analyse`` and ``recommend``: from recorded failures to scenarios to learn from."""

import json
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any, get_args

import click

from roadmend.cli.command import ExampleCommand
from roadmend.cli.language_options import LanguageChoice, language_options, show_usage
from roadmend.cli.options import FILE, JSON, PATH, WORKERS, options_of
from roadmend.cli.output import counting, show_rows
from roadmend.cli.sera_options import (
    BANK,
    EMBEDDER,
    PATTERN,
    filter_options,
    filters_of,
    keeping_exchanges,
    open_backend,
)
from roadmend.core.bounds import TEXT
from roadmend.core.errors import InputError
from roadmend.core.fanout import fan_out
from roadmend.core.json_text import read_json
from roadmend.core.whole_file import write_text
from roadmend.sera.analysis import Analysis, analyse, find_bags, read_incidents
from roadmend.sera.analysis_report import NOTHING, pattern_rows, report
from roadmend.sera.bank import Bank
from roadmend.sera.pattern import dump_patterns, parse_patterns, read_patterns
from roadmend.sera.recommendation import Stage, content_of
from roadmend.sera.recommendation import recommend as recommend_from
from roadmend.world.scenario_file import load_scenario


@dataclass(frozen=True)
class AnalyseOptions:
    """Which bags, and who looks for patterns."""

    bags: Annotated[tuple[Path, ...], click.argument("bags", nargs=-1, required=True, type=PATH)]
    language: Annotated[LanguageChoice, language_options]
    out: Annotated[
        Path | None,
        click.option(
            "--out",
            type=FILE,
            help="The patterns for 'sera recommend', JSON; a report as .md beside it, and what a language model was asked.",
        ),
    ]
    workers: Annotated[int, WORKERS]
    as_json: Annotated[bool, JSON]


@click.command("analyse", cls=ExampleCommand, examples=["roadmend sera analyse bags --out patterns.json"])
@options_of(AnalyseOptions)
def analyse_bags(given: AnalyseOptions) -> int:
    """Find the failures and interventions in BAGS, and the patterns in them.

    BAGS are bags, or folders with bags in them. A bag that cannot be read is named, and the others go on; the exit code
    is then 1.
    """
    found = find_bags(given.bags)
    if given.out is not None and given.out.suffix == ".md":
        raise InputError("--out", f"{given.out} is where the report would go", "name a .json file")
    _refuse_other(given.out, "patterns", lambda content: parse_patterns(_listed(content), str(given.out)))
    opened = open_backend(given.language, given.out)
    readings = []
    with fan_out(given.workers, len(found)) as mapper, counting(is_transient=True) as progress:
        task = progress.add_task("bags", total=len(found))
        for reading in mapper(read_incidents, found):
            readings.append(reading)
            progress.advance(task)
    with keeping_exchanges(opened, given.out):
        analysis = analyse(readings, opened.analyser)
    if given.out is not None:
        write_text(given.out, dump_patterns(analysis.patterns))
        write_text(given.out.with_suffix(".md"), report(analysis))
    if given.as_json:
        click.echo(
            json.dumps(
                {**asdict(analysis), "usage": {model: asdict(used) for model, used in opened.usage().items()}},
                indent=2,
                allow_nan=False,
            )
        )
    else:
        _show_patterns(analysis)
        show_usage(opened.usage())
    for each in analysis.unreadable:
        click.echo(f"not read: {each.problem}", err=True)
    return 1 if analysis.unreadable else 0


def _refuse_other(out: Path | None, noun: str, read: Callable[[Any], object]) -> None:
    """Refuse to replace what ``read`` takes for none of ours: a bank, or a file of somebody else's."""
    if out is None or not out.exists():
        return
    try:
        read(read_json(out, TEXT))
    except (InputError, KeyError, TypeError):
        raise InputError(str(out), f"is there already and holds no {noun}", "choose another name") from None


def _listed(content: Any) -> list[Any]:
    return content if isinstance(content, list) else [content]


def _show_patterns(analysis: Analysis) -> None:
    if not analysis.patterns:
        click.echo(NOTHING if analysis.bags else "No bag could be read.")
        return
    show_rows(pattern_rows(analysis))


@dataclass(frozen=True)
class RecommendOptions:
    """What is looked for, where, and who reflects on it."""

    bank_file: Annotated[Path, BANK]
    embedder: Annotated[str | None, EMBEDDER]
    patterns: Annotated[tuple[str, ...], PATTERN]
    count: Annotated[
        int,
        click.option(
            "-k", "count", default=8, show_default=True, type=click.IntRange(1, 1000), help="Scenarios a pattern."
        ),
    ]
    seed: Annotated[
        int,
        click.option("--seed", default=0, show_default=True, type=click.IntRange(0), help="Of the random selection."),
    ]
    exclude: Annotated[
        tuple[Path, ...],
        click.option(
            "--exclude",
            multiple=True,
            type=FILE,
            help="Scenario file that must not come, as one of the evaluation set, under whatever name. May be repeated.",
        ),
    ]
    language: Annotated[LanguageChoice, language_options]
    out: Annotated[
        Path | None,
        click.option("--out", type=FILE, help="The selections as JSON; beside it what a language model was asked."),
    ]
    terms: Annotated[dict[str, tuple[str, ...]], filter_options]
    as_json: Annotated[bool, JSON]


@click.command(
    cls=ExampleCommand,
    examples=[
        "roadmend sera recommend --bank my.bank --pattern patterns.json -k 8 --out selection.json",
        "roadmend sera recommend --bank my.bank --pattern 'a cyclist crosses at night'",
    ],
)
@options_of(RecommendOptions)
def recommend(given: RecommendOptions) -> None:
    """Select the best scenarios for each failure pattern, and swap what the selection as a whole is better without."""
    wanted = [pattern for each in given.patterns for pattern in read_patterns(each)]
    excluded = [load_scenario(path) for path in given.exclude]
    filters = filters_of(given.terms)
    _refuse_other(given.out, "selection", lambda content: [content[name] for name in (*get_args(Stage), "measures")])
    asked = open_backend(given.language, given.out)
    with Bank(given.bank_file, given.embedder) as opened, keeping_exchanges(asked, given.out):
        found = recommend_from(opened, wanted, given.count, filters, excluded, given.seed, asked.reflector)
        content = content_of(found, wanted, opened)
    content["usage"] = {model: asdict(used) for model, used in asked.usage().items()}
    text = json.dumps(content, indent=2)
    if given.out is not None:
        write_text(given.out, text + "\n")
    if given.as_json:
        click.echo(text)
    else:
        _show_selection(content)
        show_usage(asked.usage())


def _show_selection(content: dict[str, Any]) -> None:
    show_rows(
        [
            ("pattern", "score", "name", "words"),
            *((each["pattern"], f"{each['score']:.3f}", each["name"], each["words"]) for each in content["refined"]),
        ]
    )
    for swap in content["swaps"]:
        click.echo(f"{swap['out']} -> {swap['into']}: {swap['reason']}")
    measures = [
        (name, *(f"{value:.3f}" if isinstance(value, float) else str(value) for value in values.values()))
        for name, values in content["measures"].items()
    ]
    show_rows([("selection", *content["measures"]["initial"]), *measures])
    if content["missing"]:
        click.echo(f"{content['missing']} places stay empty: the bank has no more that pass")
