"""``roadmend bench ordinary``: what repair costs where nothing was wrong, and what a method fixes at a given price."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import click
from rich.progress import Progress

from harness.benchmark_content import dump_json
from harness.benchmark_files import read_json
from harness.beside import renew
from harness.contenders import BenchmarkPlan, read_plan, resolve
from harness.grid import TABLE_SEED, Figures, Setting, alone, drive_all, random_drives
from harness.kept_models import mark_models
from harness.kept_rows import check_sizes, keep_ordinary
from harness.options import CACHED_WORK, COMMITTED, PLANS, listed_names
from harness.ordinary_tables import ordinary_tables
from harness.price_curve import Ground, add_leads, at_time_lost, curve_settings, points_of
from roadmend.cli.options import JSON, WORKERS, options_of
from roadmend.cli.output import counting, show_rows
from roadmend.core.errors import InputError
from roadmend.core.fanout import fan_out
from roadmend.core.resources import cache_folder, config_folder
from roadmend.core.whole_file import write_texts
from roadmend.reports.result_files import origin, provenance
from roadmend.training.adreft.random_case import practice_seeds
from roadmend.world.procedural_networks import KINDS, NetworkRequest, generate_configuration
from roadmend.world.scenario import Scenario
from roadmend.world.scenario_file import drawn_scenarios

FORMAT = "roadmend-ordinary/1"
FIRST_NETWORK = 5000  # seed of the first generated network of each kind; nothing is trained or chosen on them
WARM_UP, TIME_LIMIT = 300.0, 120.0  # [s] of traffic before the ego enters, and of a drive, on networks
STEM = "adreft-ordinary"
RANDOM = "random"  # what the set of random drives is called


@dataclass(frozen=True)
class OrdinaryOptions:
    """What is driven, and where it is kept."""

    policies: Annotated[
        tuple[str, ...], click.option("--policy", "policies", multiple=True, help="May be repeated.  [default: all]")
    ]
    methods: Annotated[str | None, click.option("--methods", help="Separated by commas.  [default: the plan's]")]
    count: Annotated[
        int,
        click.option(
            "--count", default=200, show_default=True, type=click.IntRange(1, 100_000), help="Random drives a family."
        ),
    ]
    first: Annotated[
        int,
        click.option(
            "--first",
            default=TABLE_SEED,
            show_default=True,
            type=click.IntRange(0, 2**31 - 100_001),
            help="Seed of the first random drive. Any other than the table's: drives that no figure here was made of.",
        ),
    ]
    networks: Annotated[
        int,
        click.option(
            "--networks",
            default=0,
            show_default=True,
            type=click.IntRange(0, 1000),
            help="SUMO networks of each kind ('roadmend networks') to drive on as well.",
        ),
    ]
    sumocfg: Annotated[
        tuple[Path, ...],
        click.option(
            "--sumocfg",
            multiple=True,
            type=click.Path(path_type=Path),
            help="SUMO configuration, or a folder of them, to drive on as well: a set each. May be repeated.",
        ),
    ]
    drives: Annotated[
        int,
        click.option("--drives", default=3, show_default=True, type=click.IntRange(1, 10_000), help="On each network."),
    ]
    futures: Annotated[
        int,
        click.option(
            "--futures",
            default=0,
            show_default=True,
            type=click.IntRange(0, 1000),
            help="Futures by which the need of every intervention is told; 0: it is not.",
        ),
    ]
    curve_count: Annotated[
        int,
        click.option(
            "--curve-count",
            default=0,
            show_default=True,
            type=click.IntRange(0, 10_000),
            help="Random drives a family of every setting of the plan's curves; 0: no curves.",
        ),
    ]
    curve_cases: Annotated[
        int,
        click.option(
            "--curve-cases",
            default=20,
            show_default=True,
            type=click.IntRange(1, 10_000),
            help="Validation violations, and successes, of each family for the same.",
        ),
    ]
    table_cases: Annotated[
        int | None,
        click.option(
            "--table-cases",
            type=click.IntRange(1, 10_000),
            help="Test violations, and successes, of each family for what is then said of them.  [default: all]",
        ),
    ]
    keep: Annotated[
        bool, click.option("--keep", is_flag=True, help="Take whatever is not measured now from the committed figures.")
    ]
    committed: Annotated[Path, COMMITTED]
    work: Annotated[Path | None, CACHED_WORK]
    out: Annotated[
        Path | None, click.option("--out", type=click.Path(path_type=Path, file_okay=False), help="Folder of results.")
    ]
    workers: Annotated[int, WORKERS]


@click.command()
@options_of(OrdinaryOptions)
@JSON
def ordinary(given: OrdinaryOptions, *, as_json: bool) -> None:
    """Drive at random with every method, and look for the best setting of each at a given loss of time.

    The settings of a curve are chosen on validation cases and random drives of their own; what is then said of the
    chosen ones was measured on the test cases and on the random drives of the table. Finished episodes are kept.
    """
    if given.first != TABLE_SEED and (given.keep or given.curve_count):
        raise click.UsageError("--first: --keep and --curve-count go with the table's drives; leave them out")
    plan, config = read_plan(PLANS / "adreft.yaml"), config_folder()
    policies = given.policies or tuple(plan.policies)
    names = listed_names(given.methods, plan.ordinary, plan.methods, "--methods")
    before = read_json(given.committed / f"{STEM}.json") if given.keep else None
    if before is not None:  # before hours of driving, not after them
        rows = before["ordinary"].get(RANDOM, {})
        is_whole = {*rows} <= {*policies} and {name for each in rows.values() for name in each} <= {"none", *names}
        check_sizes(_command(given), before, is_whole=is_whole)
    work = given.work or cache_folder() / "benchmarks" / "ordinary"
    content: dict[str, Any] = {
        "format": FORMAT,
        "provenance": provenance(_command(given)),
        "titles": {name: plan.methods[name].title for name in plan.methods},
        "ordinary": {},
        "curve": {},
        "at_time_lost": {},
    }
    _check_names(given)
    _check_seeds(given, policies)
    with counting() as progress:
        sets = _sets(given, work, progress)
        for policy in policies:
            everybody, _ = resolve(plan, config, policy, [*names])
            contenders = [each for each in everybody if each.method != "none"]
            for name, scenarios in sets.items():
                settings = [alone(policy), *map(Setting.of, contenders)]
                trials = [trial for setting in settings for trial in setting.trials(scenarios, given.futures)]
                figures = drive_all(trials, work, given.workers, progress, f"{policy}: {name}")
                told = {each.title: {"contender": each.contender} for each in settings if each.contender}
                found = {
                    method: figure["ordinary"] | told.get(method, {}) for method, figure in figures[policy].items()
                }
                content["ordinary"].setdefault(name, {})[policy] = found
            if given.curve_count:
                chosen = None if given.methods is None else names
                content["curve"][policy], content["at_time_lost"][policy] = _curves(
                    plan, policy, chosen, given, work, progress
                )
    if before is not None:
        keep_ordinary(content, before, [*plan.methods])
        mark_models(content, plan, config)
    tables = ordinary_tables(content)
    if given.out is not None:
        text = "\n\n".join(table.markdown(3) for table in tables)
        made = origin(content["provenance"])
        write_texts(
            given.out,
            {f"{STEM}.json": dump_json(content) + "\n", f"{STEM}.md": f"# Ordinary driving\n\n{text}\n\n{made}\n"},
        )
        renew(given.out)
    if as_json:
        click.echo(dump_json(content))
        return
    for table in tables:
        show_rows(table.rows)


def _check_seeds(given: OrdinaryOptions, policies: Sequence[str]) -> None:
    """Refuse drives that a policy's models may have learned from."""
    for policy in policies:
        for seeds in practice_seeds(policy):
            if given.first < seeds.stop and given.first + given.count > seeds.start:
                what = f"models of {policy} practise on the drives of the seeds from {seeds.start} to {seeds.stop - 1}"
                raise InputError("--first", what, "begin elsewhere")


def _check_names(given: OrdinaryOptions) -> None:
    """Whether each configuration makes a set of its own, for a set is called by the file's name.

    Raises:
        InputError: two are called alike, or one as a set that is driven anyway or kept.
    """
    known = {RANDOM, *(KINDS if given.networks or given.keep else ())}
    for path in given.sumocfg:
        if path.stem in known:
            mend = "rename the file; its name is the set's"
            raise InputError(f"--sumocfg {path}", f"there is another set {path.stem!r}", mend)
        known.add(path.stem)


def _sets(given: OrdinaryOptions, work: Path, progress: Progress) -> dict[str, list[Scenario]]:
    """What is driven, by name: random scenarios of the families, generated networks by kind, and those given."""
    sets = {RANDOM: random_drives(given.count, given.first)}
    seeds = range(FIRST_NETWORK, FIRST_NETWORK + given.networks)
    requests = [NetworkRequest(kind, seed, work.with_name(f"{work.name}-networks")) for kind in KINDS for seed in seeds]
    paths: dict[str, list[Path]] = {}
    task = progress.add_task("networks", total=len(requests), visible=bool(requests))
    with fan_out(given.workers, len(requests)) as mapper:
        for request, path in zip(requests, mapper(generate_configuration, requests), strict=True):
            paths.setdefault(request.kind, []).append(path)
            progress.advance(task)
    paths |= {path.stem: [path] for path in given.sumocfg}
    drives = range(given.drives)
    return sets | {name: drawn_scenarios(found, drives, WARM_UP, TIME_LIMIT) for name, found in paths.items()}


def _curves(
    plan: BenchmarkPlan,
    policy: str,
    methods: Sequence[str] | None,
    given: OrdinaryOptions,
    work: Path,
    progress: Progress,
) -> tuple[dict[str, Any], dict[str, Any]]:
    """The points of every method's curve, and the best at each price."""

    def drive(ground: Ground, settings: Sequence[Setting]) -> tuple[Figures, Figures]:
        return ground.drive(settings, work, given.workers, progress, f"{len(settings)} settings")

    settings = curve_settings(plan, config_folder(), policy, methods)
    curves = points_of(settings, drive(Ground.choosing(policy, given.curve_count, given.curve_cases), settings))
    shown = Ground.showing(policy, given.count, given.table_cases)
    found = at_time_lost(curves, settings, shown, drive)
    titles = {point["setting"] for prices in found.values() for point in prices.values() if point is not None}
    chosen = [setting for setting in settings if setting.title in titles]
    add_leads(found, shown.case_results(chosen, work, given.workers, progress))
    return curves, found


def _command(given: OrdinaryOptions) -> str:
    """The command again, without places on this machine."""
    parts = ["./roadmend bench ordinary", *(f"--policy {policy}" for policy in given.policies)]
    parts += [f"--methods {''.join(given.methods.split())}"] if given.methods else []
    parts += [f"--count {given.count}"] if given.count != 200 else []
    parts += [f"--first {given.first}"] if given.first != TABLE_SEED else []
    parts += [f"--networks {given.networks}"] if given.networks else []
    parts += [f"--sumocfg {path.name}" for path in given.sumocfg]
    parts += [f"--drives {given.drives}"] if given.networks or given.sumocfg else []
    parts += [f"--futures {given.futures}"] if given.futures else []
    parts += [f"--curve-count {given.curve_count} --curve-cases {given.curve_cases}"] if given.curve_count else []
    parts += [f"--table-cases {given.table_cases}"] if given.table_cases else []
    parts += ["--keep"] * given.keep
    return " ".join(parts)
