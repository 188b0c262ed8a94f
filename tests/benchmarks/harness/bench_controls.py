"""``roadmend bench controls``: is it the timing, does it hold in other futures, and how little would have done?"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import fmean
from typing import Annotated, Any

import click
import numpy as np

from harness.benchmark_content import OURS, dump_json
from harness.benchmark_files import read_json
from harness.beside import renew
from harness.contenders import read_plan, resolve
from harness.control_jobs import FORMAT, ControlJob, ControlResult, run_controls
from harness.grid import Setting
from harness.kept_models import mark_models, row_title
from harness.kept_rows import keep_controls
from harness.options import CACHED_WORK, COMMITTED, PLANS, listed_names
from harness.policy_benchmarks import select
from harness.table import Table, number, span
from roadmend.cli.options import JSON, WORKERS, options_of
from roadmend.cli.output import counting, show_rows
from roadmend.core.fanout import fan_out
from roadmend.core.journal import Journal
from roadmend.core.resources import cache_folder, config_folder
from roadmend.core.whole_file import write_texts
from roadmend.measures.intervals import bootstrap, by_group
from roadmend.reports.result_files import origin, provenance
from roadmend.world.case_name import search_of
from roadmend.world.corpus import TOUCH, corpus_of
from roadmend.world.families import FAMILIES

CONTENT = "roadmend-controls/1"
STEM = "adreft-controls"
METHODS = "rule,rss,predictive,adreft,precaution"
HARD = 6.0  # [m/s] impact speed from which a violation is told apart


@dataclass(frozen=True)
class ControlOptions:
    """What is driven, and where it is kept."""

    policies: Annotated[
        tuple[str, ...], click.option("--policy", "policies", multiple=True, help="May be repeated.  [default: all]")
    ]
    methods: Annotated[
        str,
        click.option("--methods", default=METHODS, show_default=True, help="With commas."),
    ]
    cases: Annotated[
        int | None,
        click.option(
            "--cases", type=click.IntRange(1, 10_000), help="Violations, and successes, of each family.  [default: all]"
        ),
    ]
    bound: Annotated[bool, click.option("--bound/--no-bound", default=True, show_default=True, help="Informed bound.")]
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
@options_of(ControlOptions)
@JSON
def controls(given: ControlOptions, *, as_json: bool) -> None:
    """Hold each method against its own braking at random times, in other futures, and against the informed bound."""
    plan, config = read_plan(PLANS / "adreft.yaml"), config_folder()
    names = listed_names(given.methods, (), plan.methods, "--methods")
    work = given.work or cache_folder() / "benchmarks" / "controls"
    content: dict[str, Any] = {
        "format": CONTENT,
        "provenance": provenance(_command(given)),
        "titles": {name: method.title for name, method in plan.methods.items()},
        "controls": {},
        "bound": {},
    }
    with (
        counting() as progress,
        Journal(work / "results.jsonl", FORMAT, owns_folder=True) as journal,
        fan_out(given.workers) as mapper,
    ):

        def run(what: str, jobs: Sequence[ControlJob]) -> list[ControlResult]:
            task = progress.add_task(what, total=len(jobs))
            found = []
            for result in run_controls(jobs, journal, mapper):
                found.append(result)
                progress.advance(task)
            return found

        for policy in given.policies or tuple(plan.policies):
            cases = select(corpus_of(policy), [*FAMILIES], given.cases, "test")
            contenders, _ = resolve(plan, config, policy, [*names])
            content["controls"][policy] = {"shuffled": {}}
            own: list[ControlResult] = []
            for contender in contenders:
                setting = Setting.of(contender)
                results = run(f"{policy}: {contender.name}", [ControlJob(case, policy, setting) for case in cases])
                own = results if contender.name == OURS else own
                figures = {**shuffle_figures(results), "contender": setting.contender}
                content["controls"][policy]["shuffled"][contender.name] = figures
            if given.bound:
                jobs = [ControlJob(case, policy, None) for case in cases if case.is_violation]
                content["bound"][policy] = {"informed": bound_figures(run(f"{policy}: informed bound", jobs), own)}
    if given.keep:
        keep_controls(content, read_json(given.committed / f"{STEM}.json"), [*plan.methods])
        mark_models(content, plan, config)
    tables = [_controls_table(content), *([_bound_table(content)] if content["bound"] else [])]
    if given.out is not None:
        text = "\n\n".join(table.markdown(3) for table in tables)
        made = origin(content["provenance"])
        write_texts(
            given.out, {f"{STEM}.json": dump_json(content) + "\n", f"{STEM}.md": f"# Controls\n\n{text}\n\n{made}\n"}
        )
        renew(given.out)
    if as_json:
        click.echo(dump_json(content))
        return
    for table in tables:
        show_rows(table.rows)


def shuffle_figures(results: Sequence[ControlResult]) -> dict[str, Any]:
    """A method beside its own braking at random times, in percent; intervals of the paired bootstrap over searches."""
    violations = [result for result in results if result.is_violation]
    successes = [result for result in results if not result.is_violation]
    tables = tuple(
        np.array([(each.worth, each.shuffled, 1.0) for each in part], dtype=np.float64).reshape(-1, 3)
        for part in (violations, successes)
    )
    strata = tuple(
        by_group(table, [search_of(each.case) for each in part])
        for table, part in zip(tables, (violations, successes), strict=True)
    )

    def difference(sums: Sequence[Any]) -> Any:
        fix, deg = (total / total[:, 2:] for total in sums)
        return 100.0 * ((fix[:, 0] - fix[:, 1]) - (deg[:, 0] - deg[:, 1]))

    fix, deg = (100.0 * table.mean(axis=0) if len(table) else np.zeros(3) for table in tables)
    hard = [each for each in violations if (each.impact_speed or 0.0) >= HARD]
    touches = [each for each in violations if (each.impact_speed or 0.0) < TOUCH]
    return {
        "violations": len(violations),
        "successes": len(successes),
        "delta_e": float(fix[0] - deg[0]),
        "shuffled_fix": float(fix[1]),
        "shuffled_deg": float(deg[1]),
        "shuffled_delta_e": float(fix[1] - deg[1]),
        "more_than_shuffled": float(fix[0] - deg[0] - fix[1] + deg[1]),
        "interval": list(bootstrap(strata, difference)) if all(len(part) > 1 for part in strata) else None,
        "in_futures": _percent(violations, lambda each: each.in_futures or 0.0),
        "fix_hard": _percent(hard, lambda each: each.worth),
        "fix_touches": _percent(touches, lambda each: each.worth),
        "hard": len(hard),
        "touches": len(touches),
        "dose_violations": fmean(each.dose for each in violations) if violations else None,
        "shuffled_dose_violations": fmean(each.shuffled_dose for each in violations) if violations else None,
    }


def bound_figures(results: Sequence[ControlResult], own: Sequence[ControlResult] = ()) -> dict[str, Any]:
    """The informed bound over violations.

    Args:
        results: of the bound.
        own: ADReFT's, which is held against the bound in the cases that the bound repairs; empty where it was not driven.
    """
    found = [each for each in results if each.bound is not None]
    repaired = {each.case for each in found}
    doses = [each.dose for each in own if each.case in repaired]
    return {
        "violations": len(results),
        "repaired": len(found),
        "dose": fmean(each.dose for each in found) if found else None,
        "adreft_dose": fmean(doses) if doses else None,
        "in_futures": _percent(found, lambda each: each.bound_in_futures or 0.0),
    }


def _percent(results: Sequence[ControlResult], value: Callable[[ControlResult], float]) -> float | None:
    return 100.0 * fmean(map(value, results)) if results else None


def _controls_table(content: Mapping[str, Any]) -> Table:
    rows: list[tuple[str, ...]] = [
        (
            "policy",
            "method",
            "ΔE",
            "shuffled",
            "more",
            "95 %",
            "in futures [%]",
            "hard %Fix",
            "touches %Fix",
            "dose [s]",
            "shuffled dose [s]",
        )
    ]
    for policy, found in content["controls"].items():
        for method, figures in found["shuffled"].items():
            rows.append(
                (
                    policy,
                    row_title(content["titles"], method, figures),
                    number(figures["delta_e"]),
                    number(figures["shuffled_delta_e"]),
                    number(figures["more_than_shuffled"]),
                    span(figures["interval"]),
                    number(figures["in_futures"]),
                    number(figures["fix_hard"]),
                    number(figures["fix_touches"]),
                    number(figures["dose_violations"], 2),
                    number(figures.get("shuffled_dose_violations"), 2),
                )
            )
    note = (
        "Shuffled: the method's own braking of each case, block by block, at random times before the impact, until as "
        "much of it is spent as the method took (less where the drive ends before). In futures: share of five futures of "
        "each violation, the method at work from 8 s before it, that reach the goal. "
        f"Hard: impacts of {HARD:g} m/s and more; touches: below {TOUCH:g} m/s. Doses: on violations."
    )
    return Table("Timing, other futures, impact speed", note, tuple(rows))


def _bound_table(content: Mapping[str, Any]) -> Table:
    rows: list[tuple[str, ...]] = [
        (
            "policy",
            "violations",
            "repaired by a pulse",
            "dose [s]",
            "ADReFT's dose on them [s]",
            "in further futures [%]",
        )
    ]
    for policy, found in content["bound"].items():
        figures = found["informed"]
        rows.append(
            (
                policy,
                str(figures["violations"]),
                str(figures["repaired"]),
                number(figures["dose"], 2),
                number(figures.get("adreft_dose"), 2),
                number(figures["in_futures"]),
            )
        )
    note = (
        "The least of a few pulses that brings five futures of a case to the goal at once, tried in ten others. Doses: "
        "on the cases that it repairs, of the case itself."
    )
    return Table("Informed bound", note, tuple(rows))


def _command(given: ControlOptions) -> str:
    parts = ["./roadmend bench controls", *(f"--policy {policy}" for policy in given.policies)]
    parts += [f"--methods {''.join(given.methods.split())}"] if given.methods != METHODS else []
    parts += [f"--cases {given.cases}"] if given.cases else []
    return " ".join(parts + ["--no-bound"] * (not given.bound) + ["--keep"] * given.keep)
