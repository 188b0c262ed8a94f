"""``roadmend evaluate``: policies times repair methods times scenarios."""

import json
from dataclasses import dataclass
from pathlib import Path

import click

from roadmend.api.evaluation import EvaluationReport
from roadmend.cli.call import call_again
from roadmend.cli.command import ExampleCommand
from roadmend.cli.driver_options import METHOD_NAME, POLICIES, TUNED
from roadmend.cli.options import FILE, JSON, PATH, RESULT_FOLDER, WORKERS
from roadmend.cli.output import counting, show_rows
from roadmend.cli.scenario import FAMILY_NAME
from roadmend.cli.sumo_options import DRIVES, TIME_LIMIT, WARM_UP, WARM_UP_OPTION, egos, sumocfg, time_limit
from roadmend.core.errors import InputError
from roadmend.core.journal import Journal
from roadmend.measures.evaluation import FORMAT, run_trials, trials_of
from roadmend.measures.evaluation_figures import evaluate as figures_of
from roadmend.measures.evaluation_figures import meanings, network_rows
from roadmend.measures.fitting import fitting_accounts
from roadmend.reports.result_files import provenance
from roadmend.world.corpus import SPLITS, load_corpus
from roadmend.world.families import FAMILIES, sample_scenario
from roadmend.world.scenario import Scenario
from roadmend.world.scenario_file import drawn_scenarios, load_scenarios


@click.command(
    cls=ExampleCommand,
    examples=[
        "roadmend evaluate my-scenarios --policy modular --policy neural --repair adreft --out measured",
        "roadmend evaluate --family S3 --count 50 --repair rss --repair adreft --out measured",
        "roadmend evaluate --sumocfg my/town.sumocfg --egos 10 --repair adreft --out measured",
    ],
    resumes="",
    epilog=f"The table: {meanings()}.",
)
@click.argument("scenarios", nargs=-1, type=PATH)
@POLICIES
@click.option(
    "--repair",
    "methods",
    multiple=True,
    default=["adreft"],
    show_default=True,
    type=METHOD_NAME,
    help="May be repeated; none and random are always beside it.",
)
@click.option("--corpus", type=FILE, help="The cases of a corpus instead of SCENARIOS.")
@click.option("--split", type=click.Choice(SPLITS), help="Of the corpus.  [default: test]")
@click.option(
    "--family", "families", multiple=True, type=FAMILY_NAME, help="Random scenarios instead. May be repeated."
)
@sumocfg(
    "Drives in the traffic of a SUMO configuration instead, of all below a folder, or on a network alone, which gets "
    "traffic. May be repeated.",
    multiple=True,
)
@egos(str(DRIVES))
@click.option(
    "--count",
    type=click.IntRange(1, 100_000),
    help="Random scenarios of each family.  [default: 20]; with --sumocfg the same as --egos.",
)
@click.option("--seed", type=click.IntRange(0, 2**30), help="Of the first of them.  [default: 0]")
@time_limit(f"With --sumocfg: seconds to drive; routes are drawn to fit.  [default: {TIME_LIMIT:g}]")
@WARM_UP_OPTION
@click.option(
    "--futures",
    default=0,
    show_default=True,
    type=click.IntRange(0, 1000),
    help="Futures of every intervention's first tick that are driven to tell whether it was needed; 0: none.",
)
@TUNED
@RESULT_FOLDER
@click.option("--page", "with_page", is_flag=True, help="Write evaluation.html as well: the table, and every episode.")
@WORKERS
@JSON
def evaluate(
    policies: tuple[str, ...],
    methods: tuple[str, ...],
    futures: int,
    tuned: bool,  # noqa: FBT001 - click gives it by name
    out: Path,
    workers: int,
    *,
    with_page: bool,
    as_json: bool,
    **chosen: object,
) -> int:
    """Measure policies with repair methods in SCENARIOS (files, or folders of files), in a corpus, or in random ones.

    Random are scenarios of a family, and drives in SUMO configurations of anybody's: traffic, start and route of each
    are drawn by its seed. 'roadmend networks' makes such configurations.

    Every policy is driven alone, with random repair and with every method. What it collides in alone can be fixed, what
    it completes can be degraded. Finished episodes are kept in the folder and not driven again. The exit code is 1 if
    some episodes could not be driven, and 2 if none could.
    """
    asked = _Asked(**chosen)  # type: ignore[arg-type] # as the options have it
    if with_page:  # before hours of driving, not after them: it needs an extra
        import roadmend.reports.evaluation_page  # noqa: F401, PLC0415
    trials = trials_of(_scenarios(asked), policies, methods, futures, is_tuned=tuned)
    accounts = fitting_accounts(policies, methods) if tuned else {}
    for line in filter(None, (line for told in accounts.values() for line in told.values())):
        click.echo(line, err=True)
    with Journal(out / "results.jsonl", FORMAT, owns_folder=True) as journal, counting() as progress:
        task = progress.add_task("episodes", total=len(trials))
        driven = run_trials(trials, journal, workers, lambda done: progress.update(task, completed=done))
    report = EvaluationReport(figures_of(driven), tuple(driven), accounts)
    content = report.content(provenance(call_again(always=("policies", "methods"))))
    network = network_rows(report.figures) if asked.sumocfg else []
    report.write(out, content, network)
    if with_page:
        report.write_page(out, content["provenance"])
    if as_json:
        click.echo(json.dumps(content, indent=2))
    elif content["episodes"]:
        show_rows(report.rows)
        if network:
            click.echo("\nOver the network:")
            show_rows(network)
    for fault in report.faults:
        click.echo(fault, err=True)
    if not content["episodes"]:
        return 2
    return 1 if report.faults else 0


@dataclass(frozen=True)
class _Asked:
    """The options that say what is driven."""

    scenarios: tuple[Path, ...]
    corpus: Path | None
    split: str | None
    families: tuple[str, ...]
    sumocfg: tuple[Path, ...]
    egos: int | None
    count: int | None
    seed: int | None
    time_limit: float | None  # [s]
    warm_up: float | None  # [s]


def _scenarios(asked: _Asked) -> list[Scenario]:
    """The scenarios that the options stand for."""
    is_drawn = bool(asked.families or asked.sumocfg)
    is_drawn = is_drawn or any(each is not None for each in (asked.count, asked.egos, asked.seed))
    if bool(asked.scenarios) + (asked.corpus is not None) + is_drawn > 1:
        raise click.UsageError("give SCENARIOS, or --corpus, or --family or --sumocfg with --count and --seed")
    if asked.families and asked.sumocfg:
        raise click.UsageError("give --family or --sumocfg")
    if asked.split is not None and asked.corpus is None:
        raise InputError("--split", "is of a corpus, and there is none", "name one with --corpus")
    if asked.egos is not None and asked.count is not None:
        raise click.UsageError("give --egos or --count")
    of_configurations = (("--egos", asked.egos), ("--time-limit", asked.time_limit), ("--warm-up", asked.warm_up))
    for option, given in of_configurations:
        if given is not None and not asked.sumocfg:
            raise InputError(option, "is of SUMO configurations, and there is none", "name one with --sumocfg")
    if asked.corpus is not None:
        return [case.scenario() for case in load_corpus(asked.corpus).select(split=asked.split or "test")]
    if asked.scenarios:
        return load_scenarios(asked.scenarios)
    first = asked.seed or 0
    if asked.sumocfg:
        drives = range(first, first + (asked.egos or asked.count or DRIVES))
        limit = TIME_LIMIT if asked.time_limit is None else asked.time_limit
        return drawn_scenarios(asked.sumocfg, drives, WARM_UP if asked.warm_up is None else asked.warm_up, limit)
    drawn = range(first, first + (20 if asked.count is None else asked.count))
    families = dict.fromkeys(asked.families or FAMILIES)  # each once: to drive one again tells nothing new
    return [sample_scenario(family, number) for family in families for number in drawn]
