"""``roadmend bench adreft --robustness``: how many violations testing techniques find with and without repair."""

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import click
import numpy as np
from rich.progress import Progress, TaskID

from harness.benchmark_content import dump_json
from harness.benchmark_files import read_json
from harness.benchmark_tables import robustness_table
from harness.beside import renew
from harness.contenders import BenchmarkPlan, Contender, resolve
from harness.kept_rows import keep_robustness
from harness.policy_benchmarks import Choice
from roadmend.cli.output import counting
from roadmend.core.errors import RoadmendError
from roadmend.core.fanout import fan_out
from roadmend.core.journal import entry_key
from roadmend.core.markdown import table_text
from roadmend.core.whole_file import write_texts
from roadmend.measures.driver import driver_key
from roadmend.reports.result_files import origin, provenance
from roadmend.search.attempt import CRASH
from roadmend.search.campaign import Campaign, run_campaign
from roadmend.search.evaluation import Subject, evaluate
from roadmend.search.ledger import Ledger, LedgerEntry
from roadmend.search.registry import read_technique_parameters

RUNS = 3
_SEARCH = "roadmend.search.campaign"
FIRST_SEED = 7_000_000  # beyond those of every corpus
POINTS = 50  # of each curve, at most


def run_robustness(
    plan: BenchmarkPlan,
    config: Path,
    choice: Choice,
    budget: int,
    work: Path,
    workers: int,
    out: Path | None,
    command: str,
    kept: Path | None,
    *,
    as_json: bool,
) -> int:
    """Search with every technique against every policy, with and without repair; write and show the curves.

    What is not run now is taken from the figures in the folder ``kept``, where there is one.
    """
    methods = [name for name in plan.robustness.methods if name in choice.methods]
    content: dict[str, Any] = {
        "format": "roadmend-robustness/1",
        "provenance": provenance(command),
        "techniques": plan.robustness.techniques,
        "families": [*choice.families],
        "runs": RUNS,
        "budget": budget,
        "policies": {},
        "not_run": [],
    }
    with counting() as progress:
        for policy in choice.policies:
            contenders, absences = resolve(plan, config, policy, methods)
            content["not_run"] += [{"policy": policy, "method": each.name, "reason": each.reason} for each in absences]
            if contenders:
                searcher = _Searcher(policy, choice.families, budget, work, workers, progress)
                content["policies"][policy] = {
                    technique: {contender.name: searcher.curves(contender, technique) for contender in contenders}
                    for technique in plan.robustness.techniques
                }
    if kept is not None:
        keep_robustness(content, read_json(kept / "adreft-robustness.json"), plan.robustness.methods)
    if out is not None:
        titles = {name: {"title": method.title, "group": method.group} for name, method in plan.methods.items()}
        write_robustness(out, content, titles)
        renew(out)
    if as_json:
        click.echo(dump_json(content))
        return 0
    for policy, techniques in content["policies"].items():
        for technique, curves in techniques.items():
            for method, curve in curves.items():
                found = [run[-1] for run in curve["found"]]
                click.echo(
                    f"{policy}, {technique}, {method}: {found} violations in {curve['evaluations'][-1]} scenarios"
                )
    for absence in content["not_run"]:
        click.echo(f"not run: {absence['policy']}, {absence['method']}: {absence['reason']}", err=True)
    return 0


def write_robustness(folder: Path, content: Mapping[str, Any], titles: Mapping[str, Any]) -> None:
    """Write adreft-robustness.json and, for people, adreft-robustness.md.

    Raises:
        InputError: the folder cannot be written.
    """
    table = robustness_table({"robustness": content, "titles": titles})
    rows = table_text(table.rows) if table is not None else "Nothing was run."
    made = origin(content["provenance"])
    texts = {
        "adreft-robustness.json": dump_json(content) + "\n",
        "adreft-robustness.md": f"# Robustness\n\n{rows}\n\n{made}\n",
    }
    write_texts(folder, texts)


class _Searcher:
    """Runs the searches against one policy."""

    def __init__(
        self, policy: str, families: Sequence[str], budget: int, work: Path, workers: int, progress: Progress
    ) -> None:
        self._policy, self._families, self._budget, self._workers = policy, families, budget, workers
        self._folder = work / entry_key([_SEARCH], driver_key(policy))[:16] / policy
        self._progress = progress

    def curves(self, contender: Contender, technique: str) -> dict[str, Any]:
        """Violations found so far, of each run, over scenarios run; the families go on side by side."""
        task = self._progress.add_task(
            f"{self._policy}, {technique}, {contender.name}", total=RUNS * len(self._families) * self._budget
        )
        points = np.unique(np.linspace(0, self._budget, min(POINTS, self._budget) + 1).round().astype(int))
        found = []
        for run in range(RUNS):
            hits = np.zeros(self._budget + 1, dtype=np.int64)
            for family in self._families:
                hits[1:] += np.cumsum(self._search(contender, technique, family, FIRST_SEED + run, task))
            found.append(hits[points].tolist())
        self._progress.update(task, visible=False)
        return {"evaluations": (points * len(self._families)).tolist(), "found": found}

    def _search(self, contender: Contender, technique: str, family: str, seed: int, task: TaskID) -> list[bool]:
        """Whether each evaluation of one search found a violation."""
        subject = Subject(family, self._policy, contender.method, seed)
        campaign = Campaign(subject, technique, read_technique_parameters(technique))
        folder = self._folder / f"{contender.name}-{contender.key[:16]}" / technique / f"{family}-{seed}"
        work = partial(evaluate, subject, repair=contender.parameters)
        with Ledger(folder, campaign.settings) as ledger, fan_out(self._workers) as mapper:
            self._progress.advance(task, min(self._budget, len(ledger.entries)))

            def report(_entry: LedgerEntry) -> None:
                self._progress.advance(task)

            run_campaign(campaign, ledger, partial(mapper, work), self._budget, report)
            entries = ledger.entries[: self._budget]
        crashes = [entry for entry in entries if entry.evaluation.outcome == CRASH]
        if crashes:
            raise RoadmendError(f"{folder}: a scenario could not be run: {crashes[0].evaluation.text}")
        return [entry.evaluation.is_violation for entry in entries]
