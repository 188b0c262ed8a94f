"""``roadmend corpus``: the scenarios that a policy is repaired, trained and measured on."""

import json
import statistics
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import click
from click.core import ParameterSource
from rich.progress import Progress as Bar
from rich.table import Table

from roadmend.cli.command import ExampleCommand, Group
from roadmend.cli.driver_options import POLICY
from roadmend.cli.options import FILE, FOLDER, JSON, WORKERS, only_own, options_of
from roadmend.cli.output import counting, stage_of, wide_console
from roadmend.core.errors import InputError, RoadmendError
from roadmend.core.fanout import fan_out
from roadmend.core.journal import Journal
from roadmend.core.resources import config_folder
from roadmend.measures.need import PERSISTENT
from roadmend.policies.registry import POLICY_REGISTRY
from roadmend.search.attempt import CRASH
from roadmend.search.corpus_plan import LAST_FRESH, fresh_plan, read_corpus_plan
from roadmend.search.gather import Gathered, Progress, Report, gather, gather_fresh
from roadmend.search.persistence import FORMAT as PERSISTENCE
from roadmend.search.persistence import PersistenceTeller
from roadmend.search.policy_model import policy_model
from roadmend.search.renewal import joined, without_splits_of
from roadmend.search.renewal import renew as renew_cases
from roadmend.search.rerun import FORMAT as RERUNS
from roadmend.search.rerun import Rerunner, agrees
from roadmend.search.selection import spread
from roadmend.world.corpus import SPLITS, Case, Corpus, corpus_of, load_corpus, save_corpus
from roadmend.world.families import FAMILIES, FAMILY_REGISTRY


def _file_option(command: Any) -> Any:
    file = click.option(
        "--corpus", "file", type=FILE, help="Corpus to read; that of the policy in config/corpora if not given."
    )
    return POLICY(file(command))


def _load(policy: str, file: Path | None) -> Corpus:
    """The corpus to work on: the policy's; a file's alone says whose it is, where no policy is named.

    Raises:
        InputError: there is none, it is damaged, of another policy than that named, or of code that nobody named.
    """
    is_named = click.get_current_context().get_parameter_source("policy") is not ParameterSource.DEFAULT
    if file is None or is_named:
        return corpus_of(policy, file or config_folder() / "corpora" / f"{POLICY_REGISTRY.find(policy).label}.jsonl")
    loaded = load_corpus(file)
    if loaded.policy != policy and ":" in loaded.policy:
        what = f"is of {loaded.policy!r}, code from outside that a corpus makes nobody run"
        raise InputError(str(file), what, f"name it with --policy {loaded.policy}")
    return loaded


@click.group(cls=Group, examples=["roadmend corpus show --policy modular"])
def corpus() -> None:
    """Gather, verify and show the scenarios that a policy is repaired, trained and measured on."""


@dataclass(frozen=True)
class CorpusBuildOptions:
    """What is gathered, from where, and where it goes."""

    policy: Annotated[str, POLICY]
    families: Annotated[
        tuple[str, ...],
        click.option(
            "--family",
            "families",
            multiple=True,
            metavar=f"[{'|'.join(FAMILIES)}]",
            help="May be repeated.  [default: all]",
        ),
    ]
    listed: Annotated[
        str | None,
        click.option("--families", "listed", hidden=True, help="By commas: how corpora until now say they were made."),
    ]
    searches: Annotated[
        Path,
        click.option(
            "--searches",
            required=True,
            type=FOLDER,
            help="Folder for the searches, in POLICY/FAMILY/SPLIT-NUMBER; those that are there go on.",
        ),
    ]
    out: Annotated[Path, click.option("--out", required=True, type=FILE, callback=only_own, help="File to write.")]
    plan_file: Annotated[
        Path | None,
        click.option(
            "--plan", "plan_file", type=FILE, help="YAML file that says what to gather (see config/search/corpus.yaml)."
        ),
    ]
    fresh_seed: Annotated[
        int | None,
        click.option(
            "--fresh-seed",
            type=click.IntRange(0, LAST_FRESH),
            help="Gather a test set alone, from searches with this seed that nothing else uses.",
        ),
    ]
    cases: Annotated[
        int,
        click.option(
            "--cases",
            default=10,
            show_default=True,
            type=click.IntRange(1, 1000),
            help="With --fresh-seed: violations, and as many successes, of each family.",
        ),
    ]
    allow_partial: Annotated[
        bool,
        click.option(
            "--allow-partial", is_flag=True, help="Search nothing: make do with what the searches found so far."
        ),
    ]
    workers: Annotated[int, WORKERS]
    as_json: Annotated[bool, JSON]


@corpus.command(
    cls=ExampleCommand,
    examples=["roadmend corpus build --policy modular --searches searches --out modular.jsonl"],
    resumes="",
)
@options_of(CorpusBuildOptions)
def build(given: CorpusBuildOptions) -> int:
    """Gather a corpus; exit code 1 if there were not enough cases to be found.

    The same plan gives the same file, whatever the number of workers and however often it is interrupted. Every case
    is run twice: in the search that found it, and again in a fresh simulation before it is taken.
    """
    listed = [name.strip() for name in given.listed.split(",")] if given.listed else []
    chosen = [*dict.fromkeys([*given.families, *listed])] or [*FAMILIES]
    for name in chosen:
        FAMILY_REGISTRY.find_installed(name)  # for a corpus is read with those alone
    if given.fresh_seed is not None and (given.plan_file is not None or given.allow_partial):
        raise click.UsageError("--fresh-seed goes neither with --plan nor with --allow-partial")
    plan = read_corpus_plan(given.plan_file) if given.fresh_seed is None else fresh_plan(given.fresh_seed, given.cases)
    with counting() as bar:
        report = _reporter(bar)
        if given.fresh_seed is not None:
            gathered = gather_fresh(
                given.policy, given.fresh_seed, given.cases, given.searches, given.workers, report, families=chosen
            )
        else:
            command = f"roadmend corpus build --policy {given.policy}"
            command += "".join(f" --family {name}" for name in chosen) if chosen != [*FAMILIES] else ""
            command += " --allow-partial" if given.allow_partial else ""
            gathered = gather(
                plan,
                given.policy,
                chosen,
                given.searches,
                given.workers,
                report,
                command=command,
                is_partial=given.allow_partial,
            )
    return _finish(gathered, given.out, allow_partial=given.allow_partial, as_json=given.as_json)


def _finish(gathered: Gathered, out: Path, *, allow_partial: bool, as_json: bool) -> int:
    save_corpus(gathered.corpus, out)
    if as_json:
        told = {"file": str(out), **_content(gathered.corpus), "shortages": [*map(str, gathered.shortages)]}
        click.echo(json.dumps(told, indent=2))
    else:
        _show(gathered.corpus)
        click.echo(f"{out}: {len(gathered.corpus.cases)} cases, SHA-256 {gathered.corpus.digest}")
    for shortage in gathered.shortages:
        click.echo(f"roadmend: {shortage}", err=True)
    return 1 if gathered.shortages and not allow_partial else 0


def _reporter(bar: Bar) -> Report:
    cases = bar.add_task("cases", total=None)
    stage = stage_of(bar)

    def report(progress: Progress) -> None:
        bar.update(cases, completed=progress.accepted, total=progress.wanted)
        stage(progress.stage, progress.done, progress.total)

    return report


@corpus.command(cls=ExampleCommand, examples=["roadmend corpus verify --policy modular --cases 20"])
@_file_option
@click.option(
    "--cases", "count", type=click.IntRange(1), help="Run only so many, spread over the corpus; all if not given."
)
@WORKERS
@JSON
def verify(policy: str, file: Path | None, count: int | None, workers: int, *, as_json: bool) -> int:
    """Run cases again and compare the digests of the trajectories; exit code 1 if one differs."""
    loaded = _load(policy, file)
    model = policy_model(loaded.policy)
    if model != loaded.model:
        raise RoadmendError(
            f"the corpus was gathered with model {loaded.model or 'none'} of the policy {loaded.policy}, "
            f"which now is {model or 'none'}; build it again"
        )
    every = loaded.cases
    chosen = every if count is None else spread(every, count)[:count]
    differing: list[dict[str, str]] = []
    with counting() as bar, fan_out(workers) as mapper:
        task = bar.add_task("run again", total=len(chosen))
        rerunner = Rerunner(loaded.policy, mapper)
        for case, found in zip(chosen, rerunner(chosen), strict=True):
            bar.advance(task)
            if not agrees(found, case):
                now = found.text if found.outcome == CRASH else f"{found.outcome} {found.digest[:12]}"
                differing.append({"case": case.name, "was": f"{case.outcome} {case.digest[:12]}", "is": now})
    content = {"policy": loaded.policy, "corpus": loaded.digest, "verified": len(chosen), "differing": differing}
    if as_json:
        click.echo(json.dumps(content, indent=2))
    else:
        for one in differing:
            click.echo(f"{one['case']}: was {one['was']}, is {one['is']}")
        click.echo(f"{len(chosen) - len(differing)} of {len(chosen)} cases came to the same")
    return 1 if differing else 0


@corpus.command(cls=ExampleCommand, examples=["roadmend corpus renew --policy modular --out renewed.jsonl"], resumes="")
@_file_option
@click.option("--out", type=FILE, callback=only_own, required=True, help="File for the corpus as it is now.")
@click.option(
    "--futures",
    default=20,
    show_default=True,
    type=click.IntRange(0, 1000),
    help="Futures by which the persistence of a violation is told; 0: it is not.",
)
@click.option("--with", "other", type=FILE, help="Corpus whose splits take the place of those of the same name.")
@WORKERS
@JSON
def renew(
    policy: str, file: Path | None, out: Path, futures: int, other: Path | None, workers: int, *, as_json: bool
) -> None:
    """Drive all cases again and write the corpus with what they come to now, without those that come to something else.

    For a simulator or a policy that has changed a little, where a new search would find much the same.
    """
    loaded = _load(policy, file)
    fresh = None if other is None else load_corpus(other)
    old = loaded if fresh is None else without_splits_of(loaded, fresh)
    journals = [out.with_name(f"{out.name}.{what}.jsonl") for what in ("driven", "futures")]
    with (
        Journal(journals[0], RERUNS) as finished,
        Journal(journals[1], PERSISTENCE) as told,
        counting() as bar,
        fan_out(workers) as mapper,
    ):
        tasks: dict[str, Any] = {}

        def report(what: str, done: int, total: int) -> None:
            if what not in tasks:
                tasks[what] = bar.add_task(what, total=total)
            bar.update(tasks[what], completed=done)

        teller = PersistenceTeller(loaded.policy, mapper, told)
        found = renew_cases(old, Rerunner(loaded.policy, mapper, finished), teller, futures, report)
    again = found.corpus if fresh is None else joined(found.corpus, fresh)
    save_corpus(again, out)
    for journal in journals:
        journal.unlink()
    if as_json:
        content = {"file": str(out), "moved": found.moved, "left_out": found.lost, **_content(again)}
        click.echo(json.dumps(content, indent=2))
        return
    click.echo(
        f"{out}: {len(again.cases)} cases, {found.moved} of them with another trajectory, {found.lost} left out; "
        f"SHA-256 {again.digest}"
    )


@corpus.command(cls=ExampleCommand, examples=["roadmend corpus show --policy modular"])
@_file_option
@JSON
def show(policy: str, file: Path | None, *, as_json: bool) -> None:
    """Count the cases of a corpus by family, split, technique, outcome and whom the ego hit."""
    loaded = _load(policy, file)
    if not as_json:
        _show(loaded)
        click.echo(f"{len(loaded.cases)} cases of the policy {loaded.policy}, SHA-256 {loaded.digest}")
        return
    click.echo(json.dumps(_content(loaded), indent=2))


def _content(loaded: Corpus) -> dict[str, Any]:
    return {
        "policy": loaded.policy,
        "model": loaded.model,
        "digest": loaded.digest,
        "roadmend": loaded.version,
        "command": loaded.command,
        "dropped": loaded.dropped,
        "cases": len(loaded.cases),
        "families": {
            family: {split: _count(loaded.select(family, split)) for split in SPLITS} for family in _families_of(loaded)
        },
    }


def _families_of(loaded: Corpus) -> list[str]:
    """Ours, whether they have cases or not, and those of installed packages that do."""
    return [*dict.fromkeys([*FAMILIES, *(case.family for case in loaded.cases)])]


def _count(cases: list[Case]) -> dict[str, Any]:
    violations = [case for case in cases if case.is_violation]
    speeds = [case.impact_speed for case in violations if case.impact_speed is not None]
    return {
        "violations": len(violations),
        "successes": len(cases) - len(violations),
        "searches": len({case.search_seed for case in cases}),
        "techniques": dict(Counter(case.technique for case in violations).most_common()),
        "partners": dict(Counter(case.partner or "unknown" for case in violations).most_common()),
        "touches": sum(case.is_touch for case in violations),
        "persistent": sum(case.persistence is not None and case.persistence >= PERSISTENT for case in violations),
        "median_impact_speed": statistics.median(speeds) if speeds else None,
    }


def _show(loaded: Corpus) -> None:
    titles = (
        "family",
        "split",
        "violations",
        "successes",
        "searches",
        "found by",
        "hit",
        "persistent",
        "touches",
        "impact",
    )
    table = Table(*titles, box=None, pad_edge=False, header_style="bold")
    for family in _families_of(loaded):
        for split in SPLITS:
            counts = _count(loaded.select(family, split))
            if not counts["violations"] and not counts["successes"]:
                continue
            speed = counts["median_impact_speed"]
            table.add_row(
                family,
                split,
                str(counts["violations"]),
                str(counts["successes"]),
                str(counts["searches"]),
                _listed(counts["techniques"]),
                _listed(counts["partners"]),
                str(counts["persistent"]),
                str(counts["touches"]),
                "-" if speed is None else f"{speed:.1f} m/s",
            )
    wide_console().print(table)


def _listed(counts: dict[str, int]) -> str:
    return ", ".join(f"{number} {name}" for name, number in counts.items()) or "-"
