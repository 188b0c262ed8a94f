"""``roadmend sera cycle``: generations of a policy, each learning from what the one before got wrong."""

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import click

from roadmend.cli.language_options import language_options
from roadmend.cli.options import WORKERS
from roadmend.cli.output import counting, show_rows
from roadmend.cli.sera_evaluate import chosen_set, drive_jobs
from roadmend.cli.sera_options import EMBEDDER, JSON, set_options
from roadmend.core.fanout import fan_out
from roadmend.core.journal import entry_key
from roadmend.core.resources import config_folder
from roadmend.core.whole_file import write_text, written_beside
from roadmend.measures.driver import driver_key
from roadmend.networks.checkpoint import find_model
from roadmend.policies.neural import load_model
from roadmend.reports.cycle_page import cycle_chart, cycle_page, measure_rows
from roadmend.reports.result_files import origin, provenance
from roadmend.sera.analysis import Reading, find_bags, read_incidents
from roadmend.sera.backends import BACKENDS, Backend
from roadmend.sera.bank import Bank, build_bank
from roadmend.sera.cycle import Cycle, CycleOptions, Evaluation, Generation, Tuned
from roadmend.sera.describe import entry_of
from roadmend.sera.evaluation_episode import EvaluationJob
from roadmend.sera.evaluation_set import disjoint, known_in
from roadmend.training.few_shot_settings import FewShotSettings, read_few_shot_settings
from roadmend.world.families import FAMILIES, sample_scenario
from roadmend.world.scenario import Scenario

_BANK_SEED = 600_000  # of the bank that is built where none is given; nothing else draws from there
_METHOD = "none"
Told = Callable[[str, int, int], None]  # what is being done, how much of it is done, how much there is


@click.command()
@click.option("--policy", default="neural", show_default=True, help="A neural policy that ships, or its model file.")
@click.option(
    "--bags",
    multiple=True,
    type=click.Path(path_type=Path),
    help="Bags that the first generation learns from instead of the evaluation's; or folders. May be repeated.",
)
@click.option("--generations", default=2, show_default=True, type=click.IntRange(1, 50), help="Times it is tuned.")
@set_options
@click.option(
    "--bank",
    "bank_file",
    type=click.Path(path_type=Path, dir_okay=False),
    help="Bank to learn from.  [default: one is built of random scenarios]",
)
@click.option(
    "--bank-scenarios",
    default=40,
    show_default=True,
    type=click.IntRange(1, 10_000),
    help="Of each family in the bank that is built.",
)
@EMBEDDER
@click.option(
    "-k",
    "count",
    default=24,
    show_default=True,
    type=click.IntRange(1, 1000),
    help="Scenarios to learn from in a generation, shared among the failure patterns by how many episodes show them.",
)
@click.option(
    "--config",
    "file",
    type=click.Path(path_type=Path, dir_okay=False),
    help="YAML file with the settings of the tuning; config/training/few-shot.yaml if not given.",
)
@click.option("--epochs", type=click.IntRange(1, 100), help="Instead of the settings'.")
@language_options(BACKENDS)
@click.option("--seed", default=0, show_default=True, type=click.IntRange(0, 2**31 - 1))
@WORKERS
@click.option("--out", required=True, type=click.Path(path_type=Path, file_okay=False), help="Folder; resumes there.")
@JSON
def cycle(
    policy: str,
    bags: tuple[Path, ...],
    generations: int,
    scenarios: int | None,
    first_seed: int | None,
    corpus: Path | None,
    split: str | None,
    bank_file: Path | None,
    bank_scenarios: int,
    embedder: str | None,
    count: int,
    file: Path | None,
    epochs: int | None,
    backend: str,
    settings: Path | None,
    recording: Path | None,
    attempts: int,
    seed: int,
    workers: int,
    out: Path,
    *,
    as_json: bool,
) -> int:
    """Drive, analyse the failures, recommend scenarios, tune, and drive again, for several generations.

    The evaluation set shares no scenario with the bank, and every generation learns from scenarios that are new to it.
    Everything is kept in one folder; an interrupted call goes on where it stopped. The exit code is 1 if an episode
    could not be driven.
    """
    model = find_model(policy)
    load_model(model)
    few_shot = read_few_shot_settings(file or config_folder() / "training" / "few-shot.yaml")
    few_shot = few_shot if epochs is None else few_shot.model_copy(update={"epochs": epochs})
    first = tuple(find_bags(bags)) if bags else ()
    whole_set = chosen_set(scenarios, first_seed, corpus, split)
    opened = Backend.open(backend, settings, recording, attempts)
    with counting(is_transient=True) as progress:
        whole = progress.add_task("starting", total=generations + 1)
        part = progress.add_task("", total=None)

        def told(what: str, done: int, total: int) -> None:
            progress.update(part, description=what, completed=done, total=total)

        bank_path = bank_file or _built_bank(out, bank_scenarios, told)
        evaluated = disjoint(whole_set, known_in([bank_path]))
        steps = _Steps(evaluated, few_shot, seed, out, workers, told)
        options = CycleOptions(generations, count, seed, first, json.dumps([few_shot.model_dump(mode="json"), backend]))
        found = []
        with Bank(bank_path, embedder) as bank:
            digests = [scenario.digest for scenario in evaluated]
            runs = Cycle(
                bank, opened, steps, digests, out, options, lambda what: progress.update(whole, description=what)
            )
            for generation in runs.run(str(model)):
                found.append(generation)
                progress.update(whole, completed=len(found))
                content = _content(found, out, generations)
    _write(content, out)
    if as_json:
        click.echo(json.dumps(content, indent=2))
    else:
        _show(content, out)
    return 1 if any(generation.faults for generation in found) else 0


class _Steps:
    """The steps of a cycle, over processes of this machine."""

    def __init__(
        self, scenarios: Sequence[Scenario], settings: FewShotSettings, seed: int, out: Path, workers: int, told: Told
    ) -> None:
        self._scenarios = scenarios
        self._settings = settings
        self._seed = seed
        self._out = out
        self._workers = workers
        self._told = told

    def identity(self, policy: str) -> str:
        return entry_key(["roadmend.training.few_shot"], driver_key(policy, _METHOD))

    def evaluate(self, policy: str) -> Evaluation:
        driver, folder = driver_key(policy, _METHOD), self._out / "bags"
        jobs = [EvaluationJob(one, policy, _METHOD, folder, "failures", driver) for one in self._scenarios]
        found = drive_jobs(jobs, self._out / "episodes", self._workers, lambda *done: self._told("episodes", *done))
        return Evaluation(
            tuple(episode.measures for episode in found if episode.measures is not None),
            tuple(folder / episode.bag for episode in found if episode.bag),
            tuple(episode.fault for episode in found if episode.fault),
        )

    def read(self, bags: Sequence[Path]) -> Iterator[Reading]:
        if not bags:
            return
        with fan_out(self._workers, len(bags)) as mapper:
            for done, reading in enumerate(mapper(read_incidents, bags), 1):
                self._told("bags", done, len(bags))
                yield reading

    def tune(self, policy: str, scenarios: Sequence[Scenario], selection: str, out: Path) -> Tuned:
        # torch takes seconds to import, and a cycle that finds everything done does without.
        from roadmend.training.device import choose_torch_device  # noqa: PLC0415
        from roadmend.training.few_shot import Labour, Origin, few_shot_repair  # noqa: PLC0415

        choose_torch_device("cpu", 1)
        repaired = few_shot_repair(
            Path(policy),
            scenarios,
            self._settings,
            self._seed,
            out,
            origin=Origin(selection, "", "roadmend sera cycle"),
            labour=Labour(self._workers, self._told),
        )
        return Tuned(out, repaired.kept.epochs, repaired.kept.driving_score, repaired.trials[0].driving_score)


def _built_bank(out: Path, count: int, told: Told) -> Path:
    path = out / f"families-{count}.bank"
    if not path.exists():
        total = count * len(FAMILIES)
        entries = (
            entry_of(sample_scenario(family, _BANK_SEED + place), f"family {family}")
            for place in range(count)
            for family in FAMILIES
        )
        build_bank(path, entries, report=lambda stage, done: told(f"bank: {stage}", done, total))
    return path


def _content(found: Sequence[Generation], out: Path, wanted: int) -> dict[str, Any]:
    generations = [asdict(generation) for generation in found]
    for each in generations:
        each["policy"] = _place(Path(each["policy"]), out)
        if each["tuned"] is not None:
            each["tuned"]["model"] = _place(each["tuned"]["model"], out)
    return {
        "provenance": provenance(f"./roadmend sera cycle --generations {wanted}"),
        "generations": generations,
    }


def _place(model: Path, out: Path) -> str:
    """Where a model is, as seen from the cycle's folder; the name of one from elsewhere."""
    return str(model.relative_to(out)) if model.is_relative_to(out) else model.stem


def _write(content: dict[str, Any], out: Path) -> None:
    generations = content["generations"]
    write_text(out / "cycle.json", json.dumps(content, indent=2) + "\n")
    write_text(out / "cycle.html", cycle_page(generations, origin(content["provenance"])))
    with written_beside(out / "cycle.png") as beside:
        cycle_chart(generations).savefig(beside, format="png", dpi=150)


def _show(content: dict[str, Any], out: Path) -> None:
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
