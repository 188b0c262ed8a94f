"""``roadmend bench adreft``: the paper's protocol, all methods on both policies."""

import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

from harness.adreft_cost import cost_of
from harness.adreft_labels import weak_labels
from harness.bench_robustness import run_robustness
from harness.benchmark_content import build_content, case_table, differences, dump_json, unequal
from harness.benchmark_files import read_json, write_benchmark
from harness.benchmark_run import FORMAT, RESULTS, Measured, drive, find_jobs, read_results
from harness.benchmark_tables import headline
from harness.beside import beside
from harness.contenders import BenchmarkPlan, read_plan, watched_method
from harness.kept_rows import keep_cases, keep_cost
from harness.options import CACHED_WORK, COMMITTED, PLANS, known_names, listed_names
from harness.policy_benchmarks import Choice, find_benchmarks
from roadmend.cli.options import WORKERS
from roadmend.cli.output import counting, show_rows
from roadmend.core.journal import Journal
from roadmend.core.resources import cache_folder, config_folder
from roadmend.reports.result_files import provenance
from roadmend.search.corpus_plan import LAST_FRESH
from roadmend.world.families import FAMILIES

_SHOWN = 10  # differences that --verify prints
_TABLE = ("reference", "rival", "adreft")  # groups of methods without which there is no table


@dataclass(frozen=True)
class _Options:
    """How to go about it, beside what is measured."""

    work: Path
    workers: int
    out: Path | None
    committed: Path  # folder
    command: str
    as_json: bool
    keeps: bool  # the committed rows of methods that are not asked for


@click.command()
@click.option("--policy", "policies", multiple=True, help="Policy under repair, may be repeated.  [default: all]")
@click.option("--methods", help="Methods, separated by commas.  [default: all]")
@click.option("--families", help="Families, separated by commas.  [default: all]")
@click.option(
    "--cases", type=click.IntRange(1, 10_000), help="Violations, and successes, of each family.  [default: all]"
)
@click.option(
    "--split",
    default="test",
    show_default=True,
    type=click.Choice(["validation", "test"]),
    help="Cases of the corpora: the test cases are for the final figures only.",
)
@click.option("--quick", is_flag=True, help="The main methods on a few cases, in about three minutes.")
@click.option(
    "--fresh-seed",
    type=click.IntRange(0, LAST_FRESH),
    help="Gather cases that nobody has seen with this seed, and hold the table against them (with --cases).",
)
@click.option("--robustness", is_flag=True, help="Set the testing techniques upon the policies instead (long).")
@click.option(
    "--budget",
    default=100,
    show_default=True,
    type=click.IntRange(1, 100_000),
    help="With --robustness: scenarios of each search.",
)
@click.option("--verify", is_flag=True, help="Drive everything again; exit code 1 if it differs from the committed.")
@click.option("--keep", is_flag=True, help="Take the rows of all other methods and policies from the committed table.")
@click.option("--cost/--no-cost", default=True, show_default=True, help="Measure the cost of a frame.")
@click.option(
    "--corpora", type=click.Path(path_type=Path, file_okay=False), help="Folder of the corpora.  [default: config's]"
)
@COMMITTED
@CACHED_WORK
@click.option("--out", type=click.Path(path_type=Path, file_okay=False), help="Folder for JSON, Markdown and the page.")
@WORKERS
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def adreft(
    policies: tuple[str, ...],
    methods: str | None,
    families: str | None,
    cases: int | None,
    split: str,
    fresh_seed: int | None,
    budget: int,
    corpora: Path | None,
    committed: Path,
    work: Path | None,
    out: Path | None,
    workers: int,
    *,
    quick: bool,
    robustness: bool,
    verify: bool,
    keep: bool,
    cost: bool,
    as_json: bool,
) -> int:
    """Measure every repair method on the test cases of every policy (ADReFT's tables 1 to 5 and figure 3).

    Finished episodes are kept, by all that decides them, and not driven again. A method whose model is missing is
    listed as not run.
    """
    config = config_folder()
    plan = read_plan(PLANS / "adreft.yaml")
    if fresh_seed is not None and cases is None:
        raise click.UsageError("--fresh-seed needs --cases")
    if fresh_seed is not None and split != "test":
        raise click.UsageError("fresh cases have no other split than test")
    if keep and (verify or quick or fresh_seed is not None or split != "test" or cases is not None):
        raise click.UsageError("--keep goes with the whole of the committed cases only")
    if verify and (fresh_seed is not None or robustness or split != "test"):
        raise click.UsageError("--verify goes with the committed cases only")
    if keep and not robustness:  # monitors of methods that are not measured now are kept as well
        asked = listed_names(methods, [*plan.methods], plan.methods, "--methods")
        named = {name: watched_method(plan, name) for name in plan.monitors}
        plan = plan.model_copy(update={"monitors": [name for name, method in named.items() if method in asked]})
    choice = Choice(
        known_names(policies or plan.policies, plan.policies, "--policy"),
        listed_names(methods, _usual_methods(plan, committed, quick=quick, verify=verify), plan.methods, "--methods"),
        listed_names(families, FAMILIES, FAMILIES, "--families"),
        cases if cases is not None or not quick else plan.quick.cases,
        split,
        fresh_seed,
        corpora or config / "corpora",
        is_quick=quick,
    )
    options = _Options(
        work or cache_folder() / "benchmarks" / "adreft",
        workers,
        out,
        committed,
        _command(choice, corpora, verify=verify),
        as_json,
        keep,
    )
    if robustness:
        command = options.command + f" --robustness --budget {budget}"
        return run_robustness(
            plan,
            config,
            choice,
            budget,
            options.work / "robustness",
            workers,
            out,
            command,
            committed if keep else None,
            as_json=as_json,
        )
    if verify:
        return _verify(plan, config, choice, options)
    return _measure(plan, config, choice, options, with_cost=cost)


def _measure(plan: BenchmarkPlan, config: Path, choice: Choice, options: _Options, *, with_cost: bool) -> int:
    measured = _run(plan, config, choice, options.work, options.workers)
    content = _content(measured, choice, options.command)
    if with_cost:
        most = max(measured, key=lambda each: len(each.benchmark.contenders))
        content["cost"] = cost_of(most.benchmark.contenders, is_quick=choice.is_quick)
    if choice.fresh_seed is not None:
        content["difference_to_table"] = _to_table(content, options.committed / "adreft.json")
    cases = case_table(measured)
    if options.keeps:
        before, cases_before = (read_json(options.committed / name) for name in ("adreft.json", "adreft-cases.json"))
        digests = {each.benchmark.policy: [case.digest for case in each.benchmark.cases] for each in measured}
        keep_cases(content, cases, before, cases_before, digests, [*plan.methods])
        content["cost"] = keep_cost(content["cost"], before["cost"], [*plan.methods])
    if options.out is not None:
        stem = "adreft" if options.keeps else _stem(plan, choice)
        if stem == "adreft":
            content |= beside(options.out)
            content["not_run"] += _not_asked_for(plan, content)
        write_benchmark(options.out, stem, content, cases)
    if options.as_json:
        click.echo(dump_json(content))
    else:
        _show(content)
    return 0


def _verify(plan: BenchmarkPlan, config: Path, choice: Choice, options: _Options) -> int:
    """Drive in a folder of its own, so that nothing is read that an earlier run has found."""
    kept, kept_cases = (read_json(options.committed / name) for name in ("adreft.json", "adreft-cases.json"))
    folder = options.work.with_name(f"{options.work.name}-verify")
    measured = _run(plan, config, choice, folder, options.workers)
    content = _content(measured, choice, options.command)
    moved = sorted(differences(case_table(measured), kept_cases), key=lambda each: not each.ends_otherwise)
    found = [each.text for each in moved]
    figures: list[str] = []
    if all(kept["settings"].get(name) == content["settings"][name] for name in ("families", "cases")):
        for part in ("summary", "families", "monitor"):
            figures += unequal(content[part], kept[part], part)
    shutil.rmtree(folder)
    for line in [*figures, *found][:_SHOWN]:
        click.echo(line)
    episodes = sum(len(results) for each in measured for results in each.results.values())
    otherwise = sum(each.ends_otherwise for each in moved)
    click.echo(
        f"{episodes} episodes driven again, {len(found)} differences, {otherwise} of them in how an episode ends; "
        f"{len(figures)} of the tables' figures differ"
    )
    return 1 if found or figures else 0


def _run(plan: BenchmarkPlan, config: Path, choice: Choice, work: Path, workers: int) -> list[Measured]:
    """Drive what is missing, read what is there."""
    with (
        Journal(work / RESULTS, FORMAT, owns_folder=True) as journal,
        counting() as progress,
    ):
        everybody = find_benchmarks(plan, config, choice, work, workers, progress)
        jobs = [job for benchmark in everybody for job in find_jobs(benchmark, journal, weak_labels)]
        task = progress.add_task("episodes", total=len(jobs))
        drive(jobs, journal, workers, lambda _job: progress.advance(task))
        return [read_results(benchmark, journal, weak_labels) for benchmark in everybody]


def _content(measured: Sequence[Measured], choice: Choice, command: str) -> dict[str, Any]:
    return build_content(measured, provenance(command), choice.settings)


def _to_table(content: dict[str, Any], path: Path) -> dict[str, dict[str, float]]:
    """By how much ΔE differs from the committed table's; empty where there is no table."""
    if not path.is_file():
        return {}
    table = read_json(path)["summary"]
    return {
        policy: {
            method: figures["delta_e"] - table[policy][method]["delta_e"]
            for method, figures in methods.items()
            if table.get(policy, {}).get(method, {}).get("delta_e") is not None and figures["delta_e"] is not None
        }
        for policy, methods in content["summary"].items()
    }


def _show(content: dict[str, Any]) -> None:
    show_rows(headline(content))
    for policy, methods in content.get("difference_to_table", {}).items():
        for method, value in methods.items():
            click.echo(f"{policy}, {method}: ΔE {value:+.1f} against the committed table")
    for policy, corpus in content["corpora"].items():
        if corpus["not_reproduced"]:
            click.echo(f"{policy}: {len(corpus['not_reproduced'])} cases do not run as their corpus says", err=True)
    for absence in content["not_run"]:
        click.echo(f"not run: {absence['policy']}, {absence['method']}: {absence['reason']}", err=True)


def _stem(plan: BenchmarkPlan, choice: Choice) -> str:
    if choice.fresh_seed is not None:
        return f"adreft-fresh-{choice.fresh_seed}"
    if choice.is_quick:
        return "adreft-quick"
    if choice.split != "test":
        return f"adreft-{choice.split}"
    needed = {name for name, method in plan.methods.items() if method.group in _TABLE}
    whole = [*choice.policies] == plan.policies and needed <= {*choice.methods}
    return "adreft" if whole and [*choice.families] == [*FAMILIES] and choice.cases is None else "adreft-part"


def _not_asked_for(plan: BenchmarkPlan, content: dict[str, Any]) -> list[dict[str, str]]:
    """The methods that a whole table is without because nobody asked for them, as its readers should know."""
    known = {(entry["policy"], entry["method"]) for entry in content["not_run"]}
    return [
        {"policy": policy, "method": name, "reason": "not asked for"}
        for policy, methods in content["summary"].items()
        for name in plan.methods
        if name not in methods and (policy, name) not in known
    ]


def _usual_methods(plan: BenchmarkPlan, committed: Path, *, quick: bool, verify: bool) -> Sequence[str]:
    """The methods where none are named: all of the plan, or those of the committed table where that is verified."""
    if verify:
        summary = read_json(committed / "adreft.json")["summary"]
        return [name for name in plan.methods if any(name in methods for methods in summary.values())]
    return plan.quick.methods if quick else [*plan.methods]


def _command(choice: Choice, corpora: Path | None, *, verify: bool) -> str:
    """The command again; with nothing of this machine in it but what was given."""
    context = click.get_current_context()
    given = {
        name for name in context.params if context.get_parameter_source(name) == click.core.ParameterSource.COMMANDLINE
    }
    parts = ["./roadmend bench adreft"]
    parts += [f"--policy {policy}" for policy in choice.policies if "policies" in given]
    parts += [f"--methods {','.join(choice.methods)}"] * ("methods" in given)
    parts += [f"--families {','.join(choice.families)}"] * ("families" in given)
    parts += [f"--cases {choice.cases}"] * ("cases" in given)
    parts += [f"--split {choice.split}"] * ("split" in given)
    parts += ["--quick"] * choice.is_quick
    parts += [f"--fresh-seed {choice.fresh_seed}"] * (choice.fresh_seed is not None)
    parts += [f"--corpora {corpora}"] * (corpora is not None)
    parts += ["--keep"] * bool(context.params["keep"])
    parts += ["--no-cost"] * ("cost" in given and not context.params["cost"])
    return " ".join(parts + ["--verify"] * verify)
