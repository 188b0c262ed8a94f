"""``roadmend sera cycle``: generations that each learn from what the one before got wrong."""

import json
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any

import click

from roadmend.cli.call import call_again
from roadmend.cli.command import ExampleCommand
from roadmend.cli.language_options import LanguageChoice, language_options
from roadmend.cli.options import FILE, JSON, PATH, RESULT_FOLDER, SEED, WORKERS, options_of
from roadmend.cli.output import Report, counting, show_rows, stage_of
from roadmend.cli.sera_options import (
    EMBEDDER,
    NEURAL_POLICY,
    FewShotChoice,
    SetChoice,
    few_shot_options,
    open_backend,
    set_options,
)
from roadmend.core.fanout import fan_out
from roadmend.core.journal import Journal, entry_key, file_of
from roadmend.core.whole_file import write_text, written_beside
from roadmend.measures.driver import driver_key
from roadmend.networks.checkpoint import find_model, load_checkpoint
from roadmend.policies.neural import load_model
from roadmend.repair.adreft.model import KIND
from roadmend.reports.cycle_page import cycle_chart, cycle_page, measure_rows
from roadmend.reports.result_files import origin, provenance
from roadmend.sera.analysis import BagAnalysis, find_bags, read_incidents
from roadmend.sera.bank import Bank, build_bank
from roadmend.sera.cycle import Cycle, CycleOptions, Generation, PolicyEvaluation, TunedPolicy
from roadmend.sera.describe import entry_of
from roadmend.sera.evaluation_episode import EvaluationJob, drive_jobs
from roadmend.sera.evaluation_set import disjoint, known_in
from roadmend.training.few_shot_settings import FewShotSettings, repair_model
from roadmend.world.families import FAMILIES, sample_scenario
from roadmend.world.scenario import Scenario

_EPISODES = "episodes"
_BANK_SEED = 600_000  # of the bank that is built where none is given; nothing else draws from there
_METHOD = "none"


@dataclass(frozen=True)
class CycleSettings:
    """What goes into every generation."""

    policy: Annotated[str, NEURAL_POLICY]
    bags: Annotated[
        tuple[Path, ...],
        click.option(
            "--bags",
            multiple=True,
            type=PATH,
            help="Bags that the first generation learns from instead of the evaluation's; or folders. May be repeated.",
        ),
    ]
    generations: Annotated[
        int,
        click.option(
            "--generations", default=2, show_default=True, type=click.IntRange(1, 50), help="Times it is tuned."
        ),
    ]
    chosen: Annotated[SetChoice, set_options]
    bank_file: Annotated[
        Path | None,
        click.option(
            "--bank", "bank_file", type=FILE, help="Bank to learn from.  [default: one is built of random scenarios]"
        ),
    ]
    bank_scenarios: Annotated[
        int,
        click.option(
            "--bank-scenarios",
            default=40,
            show_default=True,
            type=click.IntRange(1, 10_000),
            help="Of each family in the bank that is built.",
        ),
    ]
    embedder: Annotated[str | None, EMBEDDER]
    count: Annotated[
        int,
        click.option(
            "-k",
            "count",
            default=24,
            show_default=True,
            type=click.IntRange(1, 1000),
            help="Scenarios to learn from in a generation, shared among the failure patterns by how many episodes show them.",
        ),
    ]
    few_shot: Annotated[FewShotChoice, few_shot_options]
    language: Annotated[LanguageChoice, language_options]
    seed: Annotated[int, SEED]
    workers: Annotated[int, WORKERS]
    out: Annotated[Path, RESULT_FOLDER]
    as_json: Annotated[bool, JSON]


@click.command(
    cls=ExampleCommand, examples=["roadmend sera cycle --policy neural --generations 2 --out cycle"], resumes=""
)
@options_of(CycleSettings)
def cycle(given: CycleSettings) -> int:
    """Drive, analyse the failures, recommend scenarios, tune, and drive again, for several generations.

    The evaluation set shares no scenario with the bank, and every generation learns from scenarios that are new to it.
    Everything is kept in one folder; an interrupted call goes on where it stopped. The exit code is 1 if an episode
    could not be driven.
    """
    model = find_model(given.policy)
    load_model(model)
    few_shot = given.few_shot.read()
    repair = repair_model(few_shot)
    teacher = "" if repair is None else load_checkpoint(repair, KIND).digest
    first = tuple(find_bags(given.bags)) if given.bags else ()
    whole_set = given.chosen.read()
    opened = open_backend(given.language, given.out)
    with ExitStack() as held:
        learned = None  # before there is a folder
        if given.bank_file is not None:
            learned = _opened(held, given.bank_file, given.embedder, whole_set)
        held.enter_context(_claimed(given.out))
        progress = held.enter_context(counting(is_transient=True))
        whole = progress.add_task("starting", total=given.generations + 1)
        told = stage_of(progress)
        if learned is None:
            built = _built_bank(given.out, given.bank_scenarios, told)
            learned = _opened(held, built, given.embedder, whole_set)
        bank, evaluated = learned
        steps = _LocalSteps(evaluated, few_shot, teacher, given.seed, given.out, given.workers, told)
        options = CycleOptions(
            given.generations,
            given.count,
            given.seed,
            first,
            json.dumps([few_shot.model_dump(mode="json"), given.language.backend]),
        )
        found = []
        digests = [scenario.digest for scenario in evaluated]
        runs = Cycle(
            bank, opened, steps, digests, given.out, options, lambda what: progress.update(whole, description=what)
        )
        for generation in runs.run(str(model)):
            found.append(generation)
            progress.update(whole, completed=len(found))
            content = _content(found, given.out)
        _write(content, given.out)
    if given.as_json:
        click.echo(json.dumps(content, indent=2))
    else:
        _show_generations(content, given.out)
    return 1 if any(generation.faults for generation in found) else 0


def _opened(
    held: ExitStack, path: Path, embedder: str | None, scenarios: Sequence[Scenario]
) -> tuple[Bank, list[Scenario]]:
    """A bank for as long as the stack holds it, and the scenarios that are not in it."""
    return held.enter_context(Bank(path, embedder)), disjoint(scenarios, known_in([path]))


def _claimed(out: Path) -> Journal:
    """Marks a folder as a cycle's, and keeps other processes out; the steps are kept in files of their own.

    Raises:
        InputError: it holds something else, another process is at work there, or it cannot be written.
    """
    is_earlier = (out / _EPISODES / "results.jsonl").exists()  # cycles were not marked until now
    return Journal(out / "cycle.jsonl", "roadmend-cycle/1", owns_folder=not is_earlier)


class _LocalSteps:
    """The steps of a cycle, over processes of this machine."""

    def __init__(
        self,
        scenarios: Sequence[Scenario],
        settings: FewShotSettings,
        teacher: str,
        seed: int,
        out: Path,
        workers: int,
        told: Report,
    ) -> None:
        self._scenarios = scenarios
        self._settings = settings
        self._teacher = teacher  # digest of the model that repairs the demonstrations: a name may mean another one
        self._seed = seed
        self._out = out
        self._workers = workers
        self._told = told

    def identity(self, policy: str) -> str:
        return entry_key(["roadmend.training.few_shot"], driver_key(policy, _METHOD), self._teacher)

    def evaluate(self, policy: str) -> PolicyEvaluation:
        driver, folder = driver_key(policy, _METHOD), self._out / "bags"
        jobs = [EvaluationJob(one, policy, _METHOD, folder, "failures", driver) for one in self._scenarios]
        found = drive_jobs(jobs, self._out / _EPISODES, self._workers, lambda *done: self._told("episodes", *done))
        return PolicyEvaluation(
            tuple(episode.measures for episode in found if episode.measures is not None),
            tuple(folder / episode.bag for episode in found if episode.bag),
            tuple(episode.fault for episode in found if episode.fault),
        )

    def read(self, bags: Sequence[Path]) -> Iterator[BagAnalysis]:
        if not bags:
            return
        with fan_out(self._workers, len(bags)) as mapper:
            for done, reading in enumerate(mapper(read_incidents, bags), 1):
                self._told("bags", done, len(bags))
                yield reading

    def tune(self, policy: str, scenarios: Sequence[Scenario], selection: str, out: Path) -> TunedPolicy:
        # torch takes seconds to import, and a cycle that finds everything done does without.
        from roadmend.training.device import choose_torch_device  # noqa: PLC0415
        from roadmend.training.few_shot import Labour, TuningOrigin, few_shot_repair  # noqa: PLC0415

        choose_torch_device("cpu", 1)
        repaired = few_shot_repair(
            Path(policy),
            scenarios,
            self._settings,
            self._seed,
            out,
            origin=TuningOrigin(selection, "", "roadmend sera cycle"),
            labour=Labour(self._workers, self._told),
        )
        return TunedPolicy(out, repaired.kept.epochs, repaired.kept.driving_score, repaired.trials[0].driving_score)


def _built_bank(out: Path, count: int, told: Report) -> Path:
    """A bank of random scenarios; one of other families, or of other code, has another name."""
    code = ["roadmend.sera.bank", "roadmend.sera.describe", "roadmend.world.families"]
    path = file_of(out, entry_key(code, [*FAMILIES], _BANK_SEED, count), ".bank")
    if not path.exists():
        total = count * len(FAMILIES)
        entries = (
            entry_of(sample_scenario(family, _BANK_SEED + place), f"family {family}")
            for place in range(count)
            for family in FAMILIES
        )
        build_bank(path, entries, report=lambda stage, done: told(f"bank: {stage}", done, total))
    return path


def _content(found: Sequence[Generation], out: Path) -> dict[str, Any]:
    generations = [asdict(generation) for generation in found]
    for each in generations:
        each["policy"] = _place(Path(each["policy"]), out)
        if each["tuned"] is not None:
            each["tuned"]["model"] = _place(each["tuned"]["model"], out)
    return {"provenance": provenance(call_again(always=("policy", "generations"))), "generations": generations}


def _place(model: Path, out: Path) -> str:
    """Where a model is, as seen from the cycle's folder; the name of one from elsewhere."""
    return str(model.relative_to(out)) if model.is_relative_to(out) else model.stem


def _write(content: dict[str, Any], out: Path) -> None:
    generations = content["generations"]
    write_text(out / "cycle.json", json.dumps(content, indent=2) + "\n")
    write_text(out / "cycle.html", cycle_page(generations, origin(content["provenance"])))
    with written_beside(out / "cycle.png") as beside:
        cycle_chart(generations).savefig(beside, format="png", dpi=150)


def _show_generations(content: dict[str, Any], out: Path) -> None:
    generations = content["generations"]
    show_rows(measure_rows(generations))
    for each in generations:
        lead = f"generation {each['number']}"
        if each["tuned"] is not None:
            epochs, score, before = (each["tuned"][name] for name in ("epochs", "driving_score", "before"))
            gain = (
                "" if None in {score, before} else f", Driving Score on its validation set {before:.1f} -> {score:.1f}"
            )
            click.echo(
                f"{lead}: {each['incidents']} incidents, {len(each['patterns'])} patterns, {len(each['selected'])} scenarios "
                f"({each['swaps']} swaps); tuned for {epochs} epochs{gain}"
            )
        for note in each["notes"]:
            click.echo(f"{lead}: {note}")
        for fault in each["faults"]:
            click.echo(f"{lead}: {fault}", err=True)
    click.echo(f"{out / 'cycle.json'}, .png, .html")
