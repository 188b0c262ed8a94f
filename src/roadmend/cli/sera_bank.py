"""``roadmend sera bank``: build, show, search, export and import a scenario bank."""

import itertools
import json
from collections import Counter
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import click

from roadmend.cli.command import ExampleCommand, Group
from roadmend.cli.options import FILE, JSON, only_own, options_of
from roadmend.cli.output import show_rows, stages
from roadmend.cli.sera_options import BANK, EMBEDDER, PATTERN, filter_options, filters_of
from roadmend.core.errors import InputError
from roadmend.sera.bank import Bank, Built, Report, build_bank
from roadmend.sera.describe import entry_of, entry_of_case
from roadmend.sera.descriptor import BankEntry
from roadmend.sera.embedding import DEFAULT, FORMS, inherited_embedder
from roadmend.sera.exchange import export_bank, read_export
from roadmend.sera.pattern import read_patterns
from roadmend.sera.words import described
from roadmend.world.corpus import SPLITS, load_corpus
from roadmend.world.families import FAMILIES, sample_scenario
from roadmend.world.scenario_file import load_scenario

_OUT = click.option("--out", required=True, type=FILE, callback=only_own, help="Bank to write.")
_EMBEDDER = click.option("--embedder", help=f"One of {FORMS}.  [default: {DEFAULT}]")
_INHERITED = click.option("--embedder", help=f"One of {FORMS}.  [default: that of --bank, or {DEFAULT}]")
_COUNTED = ("family", "road", "weather", "light")


@click.group(
    cls=Group,
    examples=["roadmend sera bank build --sample 200 --out my.bank", "roadmend sera bank show --bank my.bank"],
)
def bank() -> None:
    """Build, show, search, export and import a scenario bank."""


@dataclass(frozen=True)
class BankBuildOptions:
    """What a bank is built from."""

    count: Annotated[
        int,
        click.option(
            "--sample",
            "count",
            default=0,
            show_default=True,
            type=click.IntRange(0),
            help="Draw so many of each family.",
        ),
    ]
    seed: Annotated[
        int,
        click.option(
            "--seed", default=0, show_default=True, type=click.IntRange(0), help="Of the first scenario drawn."
        ),
    ]
    corpora: Annotated[
        tuple[Path, ...],
        click.option(
            "--corpus",
            "corpora",
            multiple=True,
            type=FILE,
            help="Cases with what a policy made of them. May be repeated.",
        ),
    ]
    splits: Annotated[
        tuple[str, ...],
        click.option(
            "--split",
            "splits",
            multiple=True,
            default=("training",),
            show_default=True,
            type=click.Choice(SPLITS),
            help="Of the corpora. May be repeated.",
        ),
    ]
    scenarios: Annotated[tuple[Path, ...], click.argument("scenarios", nargs=-1, type=FILE)]
    embedder: Annotated[str | None, _EMBEDDER]
    out: Annotated[Path, _OUT]
    as_json: Annotated[bool, JSON]


@bank.command(cls=ExampleCommand, examples=["roadmend sera bank build --sample 200 --out my.bank"])
@options_of(BankBuildOptions)
def build(given: BankBuildOptions) -> None:
    """Build a bank from families, corpora and scenario files; it replaces OUT when it is whole."""
    loaded = [load_corpus(path) for path in given.corpora]
    entries = itertools.chain(
        (entry_of(load_scenario(path), f"file {path.name}") for path in given.scenarios),
        (
            entry_of_case(case, corpus)
            for corpus in loaded
            for split in dict.fromkeys(given.splits)
            for case in corpus.select(split=split)
        ),
        (
            entry_of(sample_scenario(family, given.seed + place), f"family {family}")
            for place in range(given.count)
            for family in FAMILIES
        ),
    )
    total = len(given.scenarios) + given.count * len(FAMILIES)
    total += sum(len(corpus.select(split=split)) for corpus in loaded for split in dict.fromkeys(given.splits))
    if not total:
        raise InputError("bank", "would hold nothing", "name scenario files, --sample or --corpus")
    _build(given.out, entries, given.embedder or DEFAULT, total, as_json=given.as_json)


@bank.command(
    name="import",
    cls=ExampleCommand,
    examples=["roadmend sera bank import theirs.jsonl --bank my.bank --out both.bank"],
)
@click.argument("exports", nargs=-1, required=True, type=FILE)
@click.option("--bank", "bank_file", type=FILE, help="Bank to add to.")
@_INHERITED
@_OUT
@JSON
def import_(
    exports: tuple[Path, ...], bank_file: Path | None, embedder: str | None, out: Path, *, as_json: bool
) -> None:
    """Build a bank from exports, and from another bank if there is one; OUT may be that bank itself."""
    imported = itertools.chain.from_iterable(read_export(path) for path in exports)
    if bank_file is None:
        _build(out, imported, embedder or DEFAULT, None, as_json=as_json)
        return
    with Bank(bank_file) as known:
        _build(
            out,
            itertools.chain(known.entries(), imported),
            embedder or inherited_embedder(known.embedder.name),
            None,
            as_json=as_json,
        )


def _build(out: Path, entries: Iterable[BankEntry], embedder: str, total: int | None, *, as_json: bool) -> None:
    with build_progress(total) as report:
        built = build_bank(out, entries, embedder, report)
    if as_json:
        click.echo(json.dumps({"bank": str(out), **_plain(built)}, indent=2))
        return
    click.echo(
        f"{out}: {built.added} scenarios; {built.merged} came again and {built.near_equal} nearly so and were left out"
    )


def _plain(built: Built) -> dict[str, int]:
    return {"scenarios": built.added, "merged": built.merged, "near_equal": built.near_equal}


@contextmanager
def build_progress(total: int | None) -> Iterator[Report]:
    """A bar for each stage of building a bank."""
    with stages() as report:
        yield lambda stage, done: report(stage, done, total)


@bank.command(cls=ExampleCommand, examples=["roadmend sera bank show --bank my.bank"])
@BANK
@JSON
def show(bank_file: Path, *, as_json: bool) -> None:
    """Count the scenarios of a bank by family, road, weather, light, hazard and outcome."""
    with Bank(bank_file) as opened:
        counts = _count(opened.entries())
        content: dict[str, Any] = {
            "bank": str(bank_file),
            "format": opened.meta["format"],
            "roadmend": opened.meta["roadmend"],
            "embedder": opened.meta["embedder"],
            "dimensions": opened.embedder.dimensions,
            "scenarios": len(opened),
            "index_bytes": opened.index.size,
            **{group: dict(found.most_common()) for group, found in counts.items()},
        }
    if as_json:
        click.echo(json.dumps(content, indent=2))
        return
    rows = [
        (group, ", ".join(f"{number} {name}" for name, number in found.most_common()) or "-")
        for group, found in counts.items()
    ]
    show_rows([("what", "scenarios"), *rows])
    click.echo(f"{content['scenarios']} scenarios, {content['index_bytes'] / 1e6:.1f} MB of index")


def _count(entries: Iterator[BankEntry]) -> dict[str, Counter[str]]:
    counts: dict[str, Counter[str]] = {group: Counter() for group in (*_COUNTED, "hazard", "outcome", "origin")}
    for entry in entries:
        descriptor = entry.descriptor
        facts = (descriptor.family or "none", descriptor.road.kind, descriptor.weather, descriptor.light)
        for group, value in zip(_COUNTED, facts, strict=True):
            counts[group][value] += 1
        counts["hazard"].update({str(each.kind) for each in descriptor.hazards} or {"none"})
        counts["outcome"].update({str(name) for each in descriptor.outcomes for name in each.outcomes} or {"never run"})
        counts["origin"][entry.origin] += 1
    return counts


@bank.command(cls=ExampleCommand, examples=["roadmend sera bank export --bank my.bank --out my.jsonl"])
@BANK
@click.option("--out", required=True, type=FILE, callback=only_own, help="JSON lines to write.")
@JSON
def export(bank_file: Path, out: Path, *, as_json: bool) -> None:
    """Write a bank as JSON lines."""
    with Bank(bank_file) as opened:
        export_bank(opened, out)
        count = len(opened)
    click.echo(json.dumps({"file": str(out), "scenarios": count}) if as_json else f"{out}: {count} scenarios")


@bank.command(
    cls=ExampleCommand,
    examples=["roadmend sera bank search --bank my.bank --pattern 'rear-end collision in fog' --weather foggy"],
)
@BANK
@EMBEDDER
@PATTERN
@click.option("-k", "count", default=10, show_default=True, type=click.IntRange(1, 10_000), help="Scenarios.")
@filter_options
@JSON
def search(
    bank_file: Path,
    embedder: str | None,
    patterns: tuple[str, ...],
    count: int,
    *,
    as_json: bool,
    terms: dict[str, tuple[str, ...]],
) -> None:
    """Find the scenarios that fit failure patterns best."""
    wanted = [pattern for each in patterns for pattern in read_patterns(each)]
    filters = filters_of(terms)
    with Bank(bank_file, embedder) as opened:
        found: list[dict[str, Any]] = [
            {"pattern": pattern.name, "score": round(hit.score, 4), **described(opened.entry(hit.number))}
            for pattern in wanted
            for hit in opened.search(pattern, count, filters)
        ]
    if as_json:
        click.echo(json.dumps(found, indent=2))
        return
    rows = [(each["pattern"], f"{each['score']:.3f}", each["name"], each["words"]) for each in found]
    show_rows([("pattern", "score", "name", "words"), *rows])
    if not found:
        click.echo("nothing fits: the bank is empty, or nothing passes the filters")
