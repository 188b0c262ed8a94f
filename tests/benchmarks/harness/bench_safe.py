"""``roadmend bench safe``: crash reports read, built, driven and reproduced, beside the paper's figures."""

from dataclasses import asdict
from pathlib import Path
from typing import Any

import click

from harness.figures import Figures
from harness.scoring import Scores, score_cases
from roadmend.cli.options import WORKERS
from roadmend.cli.safe import open_cases, work_through
from roadmend.policies.registry import POLICIES
from roadmend.reports.result_files import provenance
from roadmend.safe.crash_test_summary import ReproductionSummary, TestSummary, summarise_reproductions, summarise_tests
from roadmend.safe.driving import Task
from roadmend.safe.planning import plan
from roadmend.world.network import cache_folder

_PAPER: dict[str, Any] = {  # SAFE, RQ1 and RQ3: other simulators, other policies
    "reports": 50,
    "scenarios": {"IDM": 214, "PPO": 211, "BeamNG": 96, "LCTGen, IDM": 50, "AC3R, BeamNG": 19},
    "violations": {"IDM": 42, "PPO": 30, "BeamNG": 87, "LCTGen, IDM": 3, "AC3R, BeamNG": 16},
    "violation_rate": 0.3052,
    "top": {"IDM": [1, 3, 4]},
    "reproduced": {"IDM": 15, "LCTGen, IDM": 3},
    "seconds_per_scenario": [10, 25],
    "extraction": {"cases": 13, "road": 93.8, "actors": 80.0, "env": 100.0, "overall": 80.0},
}


@click.command(name="safe")
@click.argument("reports", type=click.Path(path_type=Path))
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
    policies: tuple[str, ...],
    samples: int,
    budget: int,
    seed: int,
    workers: int,
    work: Path | None,
    out: Path | None,
    *,
    as_json: bool,
) -> int:
    """Read REPORTS with the embedded backend, drive their scenarios and search for their crashes.

    Where a report's folder holds an oracle.json, what was read is scored against it.
    """
    cases = open_cases([reports])
    folder = work or cache_folder() / "benchmarks" / "safe"
    tests = plan(Task.TEST, cases, policies, folder, samples=samples, seed=seed)
    searches = plan(Task.REPRODUCE, cases, policies, folder, budget=budget, seed=seed)
    driven = work_through(tests, folder, workers, "scenarios")
    searched = work_through(searches, folder, workers, "crashes")
    tested = {policy: summarise_tests(cases, [each for each in driven if each.policy == policy]) for policy in policies}
    again = {
        policy: summarise_reproductions(cases, [each for each in searched if each.policy == policy])
        for policy in policies
    }
    scores = {name: score_cases(cases, reports, text_only=name == "text_only") for name in ("text_only", "with_sketch")}
    chosen = " ".join(f"--policy {policy}" for policy in policies)
    command = f"./roadmend bench safe REPORTS {chosen} --samples {samples} --budget {budget} --seed {seed}"
    content = {"provenance": provenance(command), **_content(len(cases), tested, again, scores)}
    Figures("safe", "From crash reports to scenarios", content, _rows(len(cases), tested, again, scores)).publish(
        out, as_json=as_json
    )
    return 0


def _content(
    reports: int,
    tested: dict[str, TestSummary],
    again: dict[str, ReproductionSummary],
    scores: dict[str, Scores | None],
) -> dict[str, Any]:
    seconds = [found.seconds_per_scenario for found in tested.values() if found.seconds_per_scenario is not None]
    read = {name: asdict(score) for name, score in scores.items() if score is not None}
    # What the backend can know is what the summary says: that is the score that counts for it.
    extraction = {"extraction": {**read["text_only"], "with_sketch": read["with_sketch"]}} if read else {}
    return {
        **extraction,
        "reports": reports,
        "built": min(found.built for found in tested.values()),
        "scenarios": max(found.scenarios for found in tested.values()),
        "violations": {policy: found.collisions for policy, found in tested.items()},
        "violations_at_fault": {policy: found.at_fault for policy, found in tested.items()},
        "violation_rate": {policy: found.violation_rate for policy, found in tested.items()},
        "top": {policy: list(found.top) for policy, found in tested.items()},
        "reports_with_two_vehicles_or_more": max(found.possible for found in again.values()),
        "reproduced": {policy: found.reproduced for policy, found in again.items()},
        "reproduced_reports": {policy: list(found.names) for policy, found in again.items()},
        "seconds_per_scenario": sum(seconds) / len(seconds) if seconds else None,
        "paper": _PAPER,
    }


def _rows(
    reports: int,
    tested: dict[str, TestSummary],
    again: dict[str, ReproductionSummary],
    scores: dict[str, Scores | None],
) -> list[list[str]]:
    rows = [["what", *tested, "paper"]]

    def add(title: str, cells: list[str], paper: str) -> None:
        rows.append([title, *cells, paper])

    found = list(tested.values())
    repeated = list(again.values())
    add("reports", [str(reports)] * len(found), "50")
    add("reports whose scenarios build and run", [str(each.built) for each in found], "-")
    add("scenarios", [str(each.scenarios) for each in found], "214 IDM, 211 PPO, 96 BeamNG")
    add("collisions", [str(each.collisions) for each in found], "42 IDM, 30 PPO, 87 BeamNG")
    add("by the ego's fault", [str(each.at_fault) for each in found], "-")
    add("violation rate", [_percent(each.violation_rate) for each in found], "30.5 %")
    add("first, second, third after", ["/".join(map(str, each.top)) or "-" for each in found], "1/3/4 IDM")
    seconds = ["-" if each.seconds_per_scenario is None else f"{each.seconds_per_scenario:.2f}" for each in found]
    add("seconds a scenario", seconds, "10 to 25")
    add("crashes reproduced", [f"{each.reproduced} of {each.reports}" for each in repeated], "15 of 50")
    add("share", [_percent(each.reproduced / each.reports) for each in repeated], "30.0 %")
    add(
        "share of those with two vehicles or more",
        [_percent(each.reproduced / each.possible if each.possible else None) for each in repeated],
        "-",
    )
    score = scores["text_only"]
    if score is not None:
        paper = _PAPER["extraction"]
        for name in ("road", "actors", "env", "overall"):
            value = f"{getattr(score, name):.1f} % of {score.cases}"
            add(f"extraction: {name}", [value] * len(found), f"{paper[name]:.1f} % of {paper['cases']}")
    whole = scores["with_sketch"]
    if whole is not None:
        add(
            "extraction: overall, what only the sketch shows asked too",
            [f"{whole.overall:.1f} % of {whole.cases}"] * len(found),
            "-",
        )
    return rows


def _percent(share: float | None) -> str:
    return "-" if share is None else f"{100.0 * share:.1f} %"
