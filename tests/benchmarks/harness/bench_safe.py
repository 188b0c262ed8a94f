"""``roadmend bench safe``: crash reports read, built, driven and reproduced, beside the paper's figures."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

from harness.crash_halves import load_halves
from harness.crash_reading import ReadCrash, read_crashes
from harness.figures import Figures
from harness.safe_extraction import gather_oracles, measure_extraction, measure_registers
from harness.safe_reproduction import measure_records, measure_reproduction
from harness.safe_rows import PAPER, rows_of
from harness.scoring import load_oracles
from roadmend.cli.options import WORKERS
from roadmend.cli.output import counting
from roadmend.cli.safe import judge_through, work_through
from roadmend.core.errors import InputError
from roadmend.core.resources import cache_folder
from roadmend.policies.registry import POLICIES
from roadmend.reports.result_files import provenance
from roadmend.safe.cases import CrashCase
from roadmend.safe.crash_record import CrashRecord, load_records
from roadmend.safe.crash_test_summary import TestSummary, summarise_tests
from roadmend.safe.driving import Task
from roadmend.safe.planning import plan
from roadmend.safe.report import find_reports, load_report

_TEXTS = Path(__file__).parents[1] / "crash_texts"
_MEASURED = "measured-*.txt"
_DRAWS = 1  # episodes of a role without a search
_PARTS = ("solver", "trained-reader")  # of the reader of texts


@dataclass(frozen=True, slots=True)
class _Bench:
    """What a run of the benchmark goes by."""

    reports: tuple[Path, ...]
    records: Mapping[str, CrashRecord]
    policies: tuple[str, ...]
    samples: int
    budget: int
    seed: int
    workers: int
    work: Path
    halves: Mapping[str, frozenset[str]]

    def read(self, *, sketch: bool, without: str | None = None, paths: Sequence[Path] | None = None) -> list[ReadCrash]:
        """Read the reports, or other paths; without a part of the reader, if one is named."""
        paths = self.reports if paths is None else paths
        with counting() as progress:
            task = progress.add_task("reading" if sketch else "reading, text only", total=len(paths))
            return read_crashes(
                paths,
                self.work,
                self.workers,
                lambda done: progress.update(task, completed=done),
                sketch=sketch,
                solver=without != "solver",
                trained=without != "trained-reader",
            )

    def cases(self, read: Sequence[ReadCrash]) -> list[CrashCase]:
        """What was read, to be built.

        Raises:
            InputError: not one could be read.
        """
        cases = [each.case(load_report(path)) for each, path in zip(read, self.reports, strict=True)]
        if all(case.crash is None for case in cases):
            raise InputError(str(self.reports[0]), "not one crash could be read", cases[0].problem)
        return cases

    def reproduce(self, cases: Sequence[CrashCase], name: str, budget: int) -> dict[str, Any]:
        """Search for the crashes, and judge what was found."""
        folder = self.work / name
        searched = work_through(
            plan(Task.REPRODUCE, cases, self.policies, folder, budget=budget, seed=self.seed),
            folder,
            self.workers,
            f"crashes, {name}",
        )
        judged = judge_through(searched, self.records, folder, self.workers) if self.records else []
        return measure_reproduction(cases, searched, judged, self.records, self.halves)

    def test(self, cases: Sequence[CrashCase]) -> dict[str, TestSummary]:
        """Drive the reports' scenarios."""
        folder = self.work / "tests"
        jobs = plan(Task.TEST, cases, self.policies, folder, samples=self.samples, seed=self.seed)
        driven = work_through(jobs, folder, self.workers, "scenarios")
        return {
            policy: summarise_tests(cases, [each for each in driven if each.policy == policy])
            for policy in self.policies
        }


@click.command(name="safe")
@click.argument("reports", type=click.Path(path_type=Path))
@click.option(
    "--crash-records",
    "records",
    type=click.Path(path_type=Path, file_okay=False, exists=True),
    help="Folder of CASE.json, what is known of each crash: the judge of reproduction goes by it.",
)
@click.option(
    "--policy", "policies", multiple=True, default=[*POLICIES], show_default=True, type=click.Choice(sorted(POLICIES))
)
@click.option("--samples", default=2, show_default=True, type=click.IntRange(1, 1000), help="Scenarios of each role.")
@click.option(
    "--budget",
    default=36,
    show_default=True,
    type=click.IntRange(1, 100_000),
    help="Episodes of each role to reproduce a crash.",
)
@click.option(
    "--without",
    multiple=True,
    type=click.Choice(["sketch", *_PARTS]),
    help="Also measure without a part. Without the search is always measured.",
)
@click.option(
    "--texts",
    default=_TEXTS,
    type=click.Path(path_type=Path, file_okay=False, exists=True),
    help="Folder of measured-NAME.txt in other words than NHTSA's, each with its NAME.oracle.json. The committed ones.",
)
@click.option("--seed", default=0, show_default=True, type=click.IntRange(0, 2**31 - 1))
@WORKERS
@click.option(
    "--work",
    type=click.Path(path_type=Path, file_okay=False),
    help="Folder for what is done; a run goes on there. The cache by default.",
)
@click.option("--out", type=click.Path(path_type=Path, file_okay=False), help="Folder for safe.json and safe.md.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def safe(
    reports: Path,
    records: Path | None,
    policies: tuple[str, ...],
    samples: int,
    budget: int,
    without: tuple[str, ...],
    texts: Path,
    seed: int,
    workers: int,
    work: Path | None,
    out: Path | None,
    *,
    as_json: bool,
) -> int:
    """Read REPORTS with the embedded backend, drive their scenarios and search for their crashes.

    What was read is scored against the oracles of the reports' folders or of the records, by the committed halves of
    the shared reports. Only totals are printed.
    """
    bench = _Bench(
        find_reports(reports),
        load_records(records) if records is not None else {},
        policies,
        samples,
        budget,
        seed,
        workers,
        work or cache_folder() / "benchmarks" / "safe",
        load_halves(),
    )
    oracles = gather_oracles(reports, records)
    text, sketch = bench.read(sketch=False), bench.read(sketch=True)
    extraction = measure_extraction(text, sketch, oracles, bench.halves)
    measured = sorted(texts.glob(_MEASURED))
    if measured:
        extraction["other_registers"] = measure_registers(bench.read(sketch=False, paths=measured), load_oracles(texts))
    cases = bench.cases(sketch)
    tested = bench.test(cases)
    found = bench.reproduce(cases, "search", budget)
    ablations: dict[str, Any] = {"search": {"reproduction": bench.reproduce(cases, "one draw", _DRAWS)}}
    if "sketch" in without:
        ablations["sketch"] = {"reproduction": bench.reproduce(bench.cases(text), "without sketch", budget)}
    for part in (each for each in _PARTS if each in without):
        bare, alone = bench.read(sketch=True, without=part), bench.read(sketch=False, without=part)
        ablations[part] = {
            "extraction": measure_extraction(alone, bare, oracles, bench.halves),
            "reproduction": bench.reproduce(bench.cases(bare), f"without {part}", budget),
        }
        if measured:
            others = measure_registers(bench.read(sketch=False, without=part, paths=measured), load_oracles(texts))
            ablations[part]["extraction"]["other_registers"] = others
    chosen = " ".join(f"--policy {policy}" for policy in policies)
    options = "".join(f" --without {name}" for name in without)
    known = " --crash-records RECORDS" if records is not None else ""
    known += "" if texts == _TEXTS else " --texts TEXTS"
    command = (
        f"./roadmend bench safe REPORTS{known} {chosen} --samples {samples} --budget {budget} --seed {seed}{options}"
    )
    content = {
        "provenance": provenance(command),
        "extraction": extraction,
        **_tests(len(cases), tested),
        "records": measure_records(bench.records, reports),
        "reproduction": {**_totals(found, is_judged=bool(bench.records)), "policies": found},
        "ablations": ablations,
        "paper": PAPER,
    }
    Figures("safe", "From crash reports to scenarios", content, rows_of(content)).publish(out, as_json=as_json)
    return 0


def _totals(found: Mapping[str, Mapping[str, Any]], *, is_judged: bool) -> dict[str, Any]:
    """The figures that stand for all policies: those of the policy with which the fewest crashes happen again.

    Without records nobody judges, and how many do is None.
    """
    least = min(found.values(), key=lambda each: each["reproduced"])
    return {
        "reports": least["reports"],
        "built": least["run"],
        "reproduced": least["reproduced"] if is_judged else None,
    }


def _tests(reports: int, tested: Mapping[str, TestSummary]) -> dict[str, Any]:
    seconds = [found.seconds_per_scenario for found in tested.values() if found.seconds_per_scenario is not None]
    return {
        "reports": reports,
        "built": min(found.built for found in tested.values()),
        "scenarios": max(found.scenarios for found in tested.values()),
        "violations": {policy: found.collisions for policy, found in tested.items()},
        "violations_at_fault": {policy: found.at_fault for policy, found in tested.items()},
        "violation_rate": {policy: found.violation_rate for policy, found in tested.items()},
        "top": {policy: list(found.top) for policy, found in tested.items()},
        "seconds_per_scenario": sum(seconds) / len(seconds) if seconds else None,
    }
