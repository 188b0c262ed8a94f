"""``roadmend safe``: from a crash report to scenarios that test the policy."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated

import click
from rich.markup import escape
from rich.table import Table

from roadmend.cli.command import ExampleCommand
from roadmend.cli.driver_options import POLICIES
from roadmend.cli.language_options import LanguageChoice, language_options, show_usage
from roadmend.cli.options import FILE, FOLDER, JSON, PATH, SEED, WORKERS, options_of
from roadmend.cli.output import counting, show_rows, wide_console
from roadmend.core.errors import InputError
from roadmend.core.whole_file import write_texts
from roadmend.language.exchange import add_usages
from roadmend.reports.crash_pages import write_crash_pages
from roadmend.reports.crash_tests import (
    JUDGED_TITLES,
    REPRODUCTION_TITLES,
    TEST_TITLES,
    draw_trial,
    judged_cells,
    report_of_reproductions,
    report_of_tests,
)
from roadmend.safe.backends import BackendOptions, open_extractor
from roadmend.safe.cases import CrashCase, gather_cases
from roadmend.safe.construction import role_name, role_title
from roadmend.safe.crash_record import CrashRecord, load_records
from roadmend.safe.crash_test_summary import summarise_reproductions, summarise_tests
from roadmend.safe.driving import CrashTestJob, CrashTestResult, Task
from roadmend.safe.extraction_run import Extracted, extract_reports
from roadmend.safe.judging import JudgedRun, judge_results, summarise_judged
from roadmend.safe.planning import do_all, plan
from roadmend.safe.report import case_of, find_reports
from roadmend.safe.sketch_claims import is_sketch_read
from roadmend.safe.stage_one import StageOneOptions
from roadmend.world.scenario_file import load_scenario


@dataclass(frozen=True)
class SafeOptions:
    """What crashes, and where what is made of them goes."""

    paths: Annotated[tuple[Path, ...], click.argument("paths", nargs=-1, required=True, type=PATH)]
    out: Annotated[
        Path,
        click.option(
            "--out",
            required=True,
            type=FOLDER,
            help="Folder for what is made; a run that was interrupted there goes on.",
        ),
    ]
    seed: Annotated[int, SEED]
    workers: Annotated[int, WORKERS]
    as_json: Annotated[bool, JSON]


def open_cases(paths: Sequence[Path]) -> list[CrashCase]:
    """The cases of the arguments; those that cannot be read are named on standard error.

    Raises:
        InputError: not one can be read.
    """
    cases = gather_cases(paths)
    problems = [case for case in cases if case.crash is None]
    if len(cases) == len(problems) == 1:  # all that there is to say is a line
        raise InputError(str(paths[0]), "not one crash could be read", problems[0].problem)
    for case in problems:
        click.echo(f"{case.name}: {case.problem}", err=True)
    if len(problems) == len(cases):
        raise InputError(str(paths[0]), "not one crash could be read", "see what is said of each above")
    return cases


def work_through(jobs: Sequence[CrashTestJob], out: Path, workers: int, label: str) -> list[CrashTestResult]:
    """Do what has not been done yet, with a bar; results come in the order of the jobs.

    Raises:
        InputError: the folder holds something else, or cannot be written.
        SimulationError: a worker process died.
    """
    with counting() as progress:
        task = progress.add_task(label, total=len(jobs))
        return do_all(jobs, out, workers, lambda done: progress.update(task, completed=done))


def judge_through(
    results: Sequence[CrashTestResult], records: Mapping[str, CrashRecord], out: Path, workers: int
) -> list[JudgedRun]:
    """Judge what a search came to, with a bar; in the order of the results.

    Raises:
        SimulationError: a worker process died.
    """
    with counting() as progress:
        task = progress.add_task("judging", total=len(results))
        return judge_results(results, records, out, workers, lambda done: progress.update(task, completed=done))


@dataclass(frozen=True)
class ExtractOptions:
    """Which reports are read, and how."""

    reports: Annotated[tuple[Path, ...], click.argument("reports", nargs=-1, required=True, type=PATH)]
    out: Annotated[Path, click.option("--out", required=True, type=FOLDER, help="Folder for the results.")]
    language: Annotated[LanguageChoice, language_options]
    no_prompt_generation: Annotated[
        bool, click.option("--no-prompt-generation", is_flag=True, help="With a model: ask without the knowledge base.")
    ]
    no_validation: Annotated[
        bool, click.option("--no-validation", is_flag=True, help="With a model: do not let it check its answers.")
    ]
    no_cross_check: Annotated[
        bool,
        click.option(
            "--no-cross-check",
            is_flag=True,
            help="With a model: hold its answers against nothing but its own validation.",
        ),
    ]
    page: Annotated[
        bool, click.option("--page", is_flag=True, help="Write CASE.html too: what was read from where, for a browser.")
    ]
    workers: Annotated[int, WORKERS]
    as_json: Annotated[bool, JSON]


@click.command(cls=ExampleCommand, examples=["roadmend safe extract reports --out read"], resumes="")
@options_of(ExtractOptions)
def extract(given: ExtractOptions) -> int:
    """Read crash reports, or folders of them; exit code 1 if one of them gave no scenario.

    A report is a folder with summary.txt and perhaps a sketch (sketch.jpg, .png), or a text file. Reports that an
    earlier call with the same settings has done are not done again.
    """
    options = StageOneOptions(
        not given.no_prompt_generation, not given.no_validation, not given.no_cross_check, given.language.attempts
    )
    paths = find_reports(*given.reports)
    extractor = open_extractor(
        given.language.backend, BackendOptions(options, given.language.settings, given.language.recording)
    )
    reader = getattr(extractor, "reader", extractor)  # of a language model, what its answers are held against
    # What a model is, by what its answers are settled, and that a sketch is read by a program that may be there or not.
    decided = [
        given.language.backend,
        str(options),
        str(is_sketch_read()),
        getattr(getattr(extractor, "model", None), "identity", ""),
        getattr(reader, "identity", "") if reader is extractor or options.cross_check else "",
    ]
    done = []
    with counting() as progress:
        task = progress.add_task("reports", total=len(paths))
        for extracted in extract_reports(paths, extractor, decided, given.out, given.workers):
            done.append(extracted)
            progress.advance(task)
    done.sort(key=lambda extracted: extracted.case)
    if given.page:
        read = {extracted.case for extracted in done if extracted.scenario is not None}
        write_crash_pages([path for path in paths if case_of(path) in read], given.out)
    usage = add_usages(extracted.usage for extracted in done)
    if given.as_json:
        total = {model: asdict(usage) for model, usage in usage.items()}
        click.echo(json.dumps({"reports": [asdict(extracted) for extracted in done], "usage": total}, indent=2))
    else:
        _show_extracted(done, given.out)
        show_usage(usage)
    return 1 if any(extracted.error for extracted in done) else 0


def _show_extracted(done: Sequence[Extracted], out: Path) -> None:
    table = Table(
        "report",
        "road",
        "lanes",
        "vehicles",
        "environment",
        "left open",
        "disputed",
        box=None,
        pad_edge=False,
        header_style="bold",
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
        table.add_row(
            escape(extracted.case),
            road,
            lanes,
            vehicles,
            environment,
            str(len(extracted.open_fields)),
            str(len(extracted.disputed_fields)),
        )
    wide_console().print(table)
    failed = sum(extracted.error is not None for extracted in done)
    known = sum(not extracted.is_new for extracted in done)
    click.echo(f"{len(done) - failed} of {len(done)} read ({known} by an earlier call), in {out}")


@click.command(cls=ExampleCommand, examples=["roadmend safe build reports --samples 3 --out built"], resumes="")
@options_of(SafeOptions)
@click.option("--samples", default=2, show_default=True, type=click.IntRange(1, 1000), help="Scenarios of each role.")
def build(given: SafeOptions, samples: int) -> int:
    """Build scenarios: every vehicle of a crash takes the place of the ego in turn.

    PATHS are crash reports (folders with a summary.txt), files of the scenario language, or folders of either. What a
    report leaves open is drawn from the seed and stands in each scenario under 'origin'. Scenarios of earlier calls stay
    in the folder, but for those of the same names, which another seed builds anew; --json names those of this one. Exit
    code 1 if a report gave none.
    """
    cases = open_cases(given.paths)
    results = work_through(
        plan(Task.BUILD, cases, [""], given.out, samples=samples, seed=given.seed),
        given.out,
        given.workers,
        "scenarios",
    )
    built = {result.report for result in results if result.scenario}
    failed = [result for result in results if not result.scenario]
    content = {
        "reports": len(cases),
        "built": len(built),
        "scenarios": [result.scenario for result in results if result.scenario],
        "failed": {case.name: case.problem for case in cases if case.crash is None}
        | {f"{result.report}-{role_name(result.vehicle)}": result.text for result in failed},
    }
    if given.as_json:
        click.echo(json.dumps(content, indent=2))
    else:
        for result in failed:
            click.echo(f"{result.report}, {role_title(result.vehicle)}: {result.text}", err=True)
        click.echo(f"{len(results) - len(failed)} scenarios from {len(built)} of {len(cases)} reports in {given.out}")
    return 0 if len(built) == len(cases) else 1


@click.command(
    name="test",
    cls=ExampleCommand,
    examples=["roadmend safe test reports --policy modular --policy neural --out tested"],
    resumes="",
)
@options_of(SafeOptions)
@POLICIES
@click.option("--samples", default=2, show_default=True, type=click.IntRange(1, 1000), help="Scenarios of each role.")
@click.option("--pictures/--no-pictures", default=True, show_default=True, help="Draw every scenario.")
def safe_test(given: SafeOptions, policies: tuple[str, ...], samples: int, *, pictures: bool) -> int:
    """Drive the scenarios of crash reports with a policy, and write report.md and report.html.

    PATHS as in 'roadmend safe build'. Exit code 1 if a report gave no scenario that runs.
    """
    cases = open_cases(given.paths)
    jobs = plan(
        Task.TEST, cases, policies, given.out, samples=samples, seed=given.seed, draw=draw_trial if pictures else None
    )
    results = work_through(jobs, given.out, given.workers, "episodes")
    tallies = {
        policy: summarise_tests(cases, [each for each in results if each.policy == policy]) for policy in policies
    }
    write_texts(given.out, report_of_tests(cases, tallies, results, given.out))
    content = {policy: found.as_dict() for policy, found in tallies.items()}
    for result in results:
        if result.driven is None:
            click.echo(f"{result.report}, {role_title(result.vehicle)}, {result.policy}: {result.text}", err=True)
    if given.as_json:
        click.echo(json.dumps(content, indent=2))
    else:
        show_rows([TEST_TITLES, *((policy, *found.cells()) for policy, found in tallies.items())])
        click.echo(f"report: {given.out / 'report.html'}")
    return 0 if all(found.built == found.reports for found in tallies.values()) else 1


@click.command(
    cls=ExampleCommand,
    examples=["roadmend safe reproduce reports --policy modular --budget 100 --out reproduced"],
    resumes="",
)
@options_of(SafeOptions)
@POLICIES
@click.option("--budget", default=36, show_default=True, type=click.IntRange(1, 100_000), help="Episodes of each role.")
@click.option(
    "--crash-records",
    "records",
    type=FOLDER,
    help="Folder of CASE.json: what is known of each crash; who judges goes by it.",
)
@click.option("--pictures/--no-pictures", default=True, show_default=True, help="Draw every crash.")
def reproduce(
    given: SafeOptions, policies: tuple[str, ...], budget: int, records: Path | None, *, pictures: bool
) -> int:
    """Vary what a report leaves open until the described crash happens with the policy in a vehicle's place.

    PATHS as in 'roadmend safe build'. A crash counts as reproduced if it happens with the policy in the place of at
    least one of its vehicles: between the same two, the same one running into the other, on the same parts of both,
    from and to the same directions, on the same type of road, with nobody moving as no vehicle can. The search goes by
    this program's own reading of the report; with records, a judge that knows nothing of it decides. Exit code 1 if a
    report could not be read, or not one of its roles ran.
    """
    known = load_records(records) if records is not None else {}
    cases = open_cases(given.paths)
    jobs = plan(
        Task.REPRODUCE,
        cases,
        policies,
        given.out,
        budget=budget,
        seed=given.seed,
        draw=draw_trial if pictures else None,
    )
    results = work_through(jobs, given.out, given.workers, "roles")
    tallies = {
        policy: summarise_reproductions(cases, [each for each in results if each.policy == policy])
        for policy in policies
    }
    judged = judge_through(results, known, given.out, given.workers) if known else []
    write_texts(given.out, report_of_reproductions(cases, tallies, results, given.out, judged))
    names = [case.name for case in cases]
    verdicts = {
        policy: summarise_judged(names, [*known], [run for run in judged if run.policy == policy])
        for policy in policies
        if known
    }
    # By the episodes: a role in which nobody came to touch anybody ran as well, and has nothing to show.
    ran = {(result.policy, result.report) for result in results if result.episodes}
    code = int(any((policy, name) not in ran for policy in policies for name in names))
    for result in results:
        if (result.policy, result.report) not in ran:
            click.echo(f"{result.report}, {role_title(result.vehicle)}: {result.text}", err=True)
    if given.as_json:
        by_records = {policy: {"by_records": asdict(found)} for policy, found in verdicts.items()}
        content = {policy: found.as_dict() | by_records.get(policy, {}) for policy, found in tallies.items()}
        click.echo(json.dumps(content, indent=2))
        return code
    show_rows([REPRODUCTION_TITLES, *((policy, *found.cells()) for policy, found in tallies.items())])
    if verdicts:
        show_rows([JUDGED_TITLES, *((policy, *judged_cells(found)) for policy, found in verdicts.items())])
    click.echo(f"report: {given.out / 'reproduction.html'}")
    return code


@click.command(cls=ExampleCommand, examples=["roadmend safe export built/scenarios/crash-v1-1.yaml --out exported"])
@click.argument("scenario", type=FILE)
@click.option("--out", required=True, type=FOLDER, help="Folder for the files.")
@JSON
def export(scenario: Path, out: Path, *, as_json: bool) -> int:
    """Write a scenario as ASAM OpenSCENARIO (NAME.xosc) and its roads as OpenDRIVE (NAME.xodr).

    SCENARIO is any scenario file with a network of its own and nobody on foot, whom this writer does not write: such a
    one is refused. The first call sets up the writer.
    """
    from roadmend.safe.openscenario import export_scenario  # noqa: PLC0415 - its writer is set up for this command alone

    story, roads = export_scenario(load_scenario(scenario), out)
    if as_json:
        click.echo(json.dumps({"openscenario": str(story), "opendrive": str(roads)}, indent=2))
    else:
        click.echo(f"{story}\n{roads}")
    return 0
