"""``roadmend bench sera``: what scenarios recommended from failures do for a policy, beside the paper's tables."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import click
from pydantic import TypeAdapter

from harness.benchmark_files import read_json
from harness.benchmark_run import FORMAT, RESULTS
from harness.fresh_cases import fresh_cases
from harness.options import CACHED_WORK, COMMITTED, PLANS
from harness.sera_experiment import Experiment
from harness.sera_kept_runs import KeptRuns
from harness.sera_page import write_sera
from harness.sera_plan import (
    SeraPlan,
    bank_entries,
    evaluation_set,
    known_scenarios,
    load_corpora,
    read_sera_plan,
)
from harness.sera_summary import build_content, main_rows, tables
from roadmend.cli.options import WORKERS
from roadmend.cli.output import counting, show_rows
from roadmend.core.errors import InputError, RoadmendError
from roadmend.core.fanout import fan_out
from roadmend.core.journal import Journal, entry_key
from roadmend.core.resources import cache_folder, config_folder
from roadmend.core.settings import check_settings
from roadmend.measures.driver import driver_key
from roadmend.networks.checkpoint import find_model
from roadmend.reports.result_files import provenance
from roadmend.search.corpus_plan import LAST_FRESH
from roadmend.sera.analyser import EmbeddedAnalyser
from roadmend.sera.analysis import read_incidents
from roadmend.sera.bank import Bank, build_bank
from roadmend.sera.evaluation_episode import EvaluatedEpisode, EvaluationJob, evaluate
from roadmend.sera.incident import Incident
from roadmend.sera.pattern import FailurePattern
from roadmend.training.device import choose_torch_device
from roadmend.training.few_shot_settings import FewShotSettings, read_few_shot_settings
from roadmend.world.corpus import Corpus
from roadmend.world.scenario import Scenario

_INCIDENTS: TypeAdapter[list[Incident]] = TypeAdapter(list[Incident])


@click.command()
@click.option("--policies", help="Neural policies, separated by commas.  [default: those of the plan]")
@click.option("--seeds", type=click.IntRange(1, 100), help="Instead of the plan's.")
@click.option("--quick", is_flag=True, help="One policy, two seeds and a small bank, in about three minutes.")
@click.option(
    "--plan", "file", type=click.Path(path_type=Path, dir_okay=False), help="Instead of tests/benchmarks/sera.yaml."
)
@click.option(
    "--in-depth/--no-in-depth",
    default=True,
    show_default=True,
    help="Half the bank and the sweep, too, as the plan says.",
)
@click.option(
    "--repaired-replay",
    is_flag=True,
    help="Tune with replay_repair (config/training/few-shot.yaml); the files are named for it.",
)
@click.option(
    "--fresh-seed",
    type=click.IntRange(0, LAST_FRESH),
    help="Evaluate on violations that nobody has seen, from searches with this seed (with --cases).",
)
@click.option("--cases", type=click.IntRange(1, 1000), help="With --fresh-seed: violations of each family.")
@COMMITTED
@CACHED_WORK
@click.option("--out", type=click.Path(path_type=Path, file_okay=False), help="Folder for sera.json, .md and .html.")
@WORKERS
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def sera(
    policies: str | None,
    seeds: int | None,
    file: Path | None,
    fresh_seed: int | None,
    cases: int | None,
    committed: Path,
    work: Path | None,
    out: Path | None,
    workers: int,
    *,
    quick: bool,
    in_depth: bool,
    repaired_replay: bool,
    as_json: bool,
) -> None:
    """Tune policies on random, recommended and reflected selections, and measure what that gains and what it loses.

    Everything that was driven or tuned is kept, by all that decides it, and not done again.
    """
    if (fresh_seed is None) != (cases is None):
        raise click.UsageError("--fresh-seed and --cases go together")
    config = config_folder()
    plan = read_sera_plan(file or PLANS / "sera.yaml", quick=quick)
    plan = plan.model_copy(
        update=({} if seeds is None else {"seeds": seeds})
        | ({} if in_depth else {"in_depth": []})
        | ({"few_shot": {**plan.few_shot, "replay_repair": True}} if repaired_replay else {})
    )
    chosen = plan.policies if policies is None else [part.strip() for part in policies.split(",")]
    models = {policy: find_model(policy) for policy in chosen}
    corpora = load_corpora(plan.evaluation, config)
    choose_torch_device("cpu", 1)
    folder = work or cache_folder() / "benchmarks" / "sera"
    with (
        Journal(folder / RESULTS, FORMAT, owns_folder=True) as journal,
        fan_out(workers) as mapper,
        counting() as progress,
    ):
        task, counts = progress.add_task("starting", total=None), dict[str, int]()

        def report(what: str) -> None:
            counts[what] = counts.get(what, 0) + 1
            told = ", ".join(f"{count} {name}" for name, count in counts.items())
            progress.update(task, advance=1, description=told)

        if fresh_seed is not None and cases is not None:
            plan = _of_fresh_cases(plan, cases)
            corpora = [fresh_cases(corpus.policy, fresh_seed, cases, folder, workers, progress) for corpus in corpora]
        results, sizes = _run(plan, config, models, corpora, KeptRuns(journal, mapper, report))
    path = committed / "retrieval.json"
    command = "./roadmend bench sera" + " --quick" * quick + (f" --policies {policies}" if policies else "")
    command += (f" --seeds {seeds}" if seeds is not None else "") + (f" --plan {file}" if file is not None else "")
    command += f" --fresh-seed {fresh_seed} --cases {cases}" * (fresh_seed is not None)
    command += "" if in_depth else " --no-in-depth"
    command += " --repaired-replay" * repaired_replay
    sizes["fresh_seed"] = fresh_seed
    content = build_content(results, read_json(path) if path.is_file() else None, provenance(command), sizes)
    if out is not None:
        stem = "sera" + "-quick" * quick + "-repaired-replay" * repaired_replay
        write_sera(out, stem if fresh_seed is None else f"{stem}-fresh-{fresh_seed}", content)
    if as_json:
        click.echo(json.dumps(content, indent=2))
        return
    for rows in (main_rows(content), *(table.rows for table in tables(content))):
        show_rows(rows)


def _of_fresh_cases(plan: SeraPlan, cases: int) -> SeraPlan:
    """The plan with all violations of a set that was gathered for it."""
    evaluation = plan.evaluation.model_copy(update={"split": "test", "violations": cases})
    return plan.model_copy(update={"evaluation": evaluation})


def _run(
    plan: SeraPlan, config: Path, models: Mapping[str, Path], corpora: Sequence[Corpus], kept_runs: KeptRuns
) -> tuple[dict[str, Any], dict[str, Any]]:
    """What each policy's experiment came to, and the sizes of all; ``corpora`` are of the evaluation set."""
    evaluated = evaluation_set(plan.evaluation, corpora)
    path = kept_runs.folder / "scenarios.bank"
    build_bank(path, bank_entries(plan.bank, config, known_scenarios(evaluated)))
    settings = _few_shot(plan, config)
    results = {}
    with Bank(path) as bank:
        for policy, model in models.items():
            logs = _Logs(policy, kept_runs)
            results[policy] = Experiment(
                model, plan, settings, evaluated, bank, kept_runs, logs.patterns, policy in plan.in_depth
            ).run()
        sizes = {
            "seeds": plan.seeds,
            "bank": len(bank),
            "evaluation": len(evaluated),
            "hard": sum(each.is_hard for each in evaluated),
            "split": plan.evaluation.split,
            "plan": plan.model_dump(mode="json"),
            "few_shot": settings.model_dump(mode="json"),
        }
    return results, sizes


def _few_shot(plan: SeraPlan, config: Path) -> FewShotSettings:
    """The shipped settings, with the plan's in their place where it has some.

    Raises:
        InputError: the plan names a setting that there is not, or a value out of range.
    """
    settings = read_few_shot_settings(config / "training" / "few-shot.yaml")
    given = {**settings.model_dump(), **plan.few_shot}
    return check_settings(given, FewShotSettings, "the plan's few_shot", "mend the plan")


class _Logs:
    """The bags of what a policy fails at, and the patterns in them."""

    def __init__(self, policy: str, kept_runs: KeptRuns) -> None:
        self._policy = policy
        self._workshop = kept_runs
        self._driver = driver_key(policy, "none")
        self._analyser = EmbeddedAnalyser()

    def patterns(self, failed: Sequence[Scenario]) -> tuple[FailurePattern, ...]:
        """The patterns in the failures of some scenarios, those with most evidence first."""
        incidents = [incident for scenario in failed for incident in self._incidents(scenario)]
        return self._analyser.analyse(incidents)

    def _incidents(self, scenario: Scenario) -> list[Incident]:
        bags = self._workshop.folder / "bags"
        job = EvaluationJob(scenario, self._policy, "none", bags, "failures", self._driver)

        def read() -> dict[str, Any]:
            (episode,) = self._workshop.mapper(evaluate, [job])
            return {"incidents": [asdict(one) for one in _read(episode, bags)]}

        kept = self._workshop.remember("analysed", entry_key([__name__], "analysed", job.key), read)
        return _INCIDENTS.validate_json(json.dumps(kept["incidents"]))


def _read(episode: EvaluatedEpisode, bags: Path) -> Sequence[Incident]:
    """The incidents of an episode; none of one that reached its goal, red light or not.

    Raises:
        RoadmendError: it could not be driven.
        InputError: its bag cannot be read.
    """
    if episode.fault:
        raise RoadmendError(episode.fault)
    if not episode.bag:
        return ()
    reading = read_incidents(bags / episode.bag)
    if reading.problem:
        raise InputError(episode.bag, reading.problem, "run the same command again")
    return reading.incidents
