"""``roadmend sera tune``: few-shot repair of a neural policy on a selection of scenarios."""

import hashlib
import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated

import click

from roadmend.cli.call import call_again
from roadmend.cli.command import ExampleCommand
from roadmend.cli.options import FILE, JSON, MODEL_OUT, SEED, WORKERS, Number, options_of
from roadmend.cli.output import show_rows, stages
from roadmend.cli.sera_options import BANK, NEURAL_POLICY, FewShotChoice, few_shot_options
from roadmend.core.errors import InputError
from roadmend.core.outcome import EventKind
from roadmend.networks.checkpoint import find_model
from roadmend.sera.bank import Bank
from roadmend.sera.evaluation_set import Known, corpus_set, disjoint
from roadmend.sera.recommendation import Stage, read_selection, scenarios_of
from roadmend.training.device import choose_torch_device
from roadmend.training.few_shot import FewShotRepair, Labour, TuningOrigin, few_shot_repair
from roadmend.world.corpus import SPLITS


@dataclass(frozen=True)
class TuneOptions:
    """What is tuned on what, and how."""

    policy: Annotated[str, NEURAL_POLICY]
    bank_file: Annotated[Path, BANK]
    selected: Annotated[
        Path,
        click.option("--selection", "selected", required=True, type=FILE, help="What 'sera recommend --json' printed."),
    ]
    stage: Annotated[
        Stage,
        click.option(
            "--stage",
            default="refined",
            show_default=True,
            type=click.Choice(["initial", "refined", "random"]),
            help="Of the selection.",
        ),
    ]
    out: Annotated[Path, MODEL_OUT]
    validation: Annotated[
        Path | None,
        click.option(
            "--validation",
            type=FILE,
            help="Corpus to choose the best epoch by, what is in the selection left out.  [default: the selection]",
        ),
    ]
    split: Annotated[
        str,
        click.option(
            "--split", default="validation", show_default=True, type=click.Choice(SPLITS), help="Of that corpus."
        ),
    ]
    few_shot: Annotated[FewShotChoice, few_shot_options]
    learning_rate: Annotated[
        float | None,
        click.option("--learning-rate", type=Number(0.0, 0.1, min_open=True), help="Instead of the settings'."),
    ]
    seed: Annotated[int, SEED]
    workers: Annotated[int, WORKERS]
    as_json: Annotated[bool, JSON]


@click.command(
    cls=ExampleCommand,
    examples=["roadmend sera tune --policy neural --bank my.bank --selection selection.json --out tuned.safetensors"],
)
@options_of(TuneOptions)
def tune(given: TuneOptions) -> None:
    """Fine-tune a neural policy on a selection, guarded against forgetting; writes a new model file.

    The expert and the policy drive the selected scenarios, the expert says what should be done, and scenes of ordinary
    episodes are mixed in. The policy drives a validation set after every epoch; that epoch is kept that scores best
    without losing on ordinary scenarios.
    """
    settings = given.few_shot.read()
    if given.learning_rate is not None:
        settings = settings.model_copy(update={"learning_rate": given.learning_rate})
    if given.out.suffix != ".safetensors":
        raise InputError("--out", f"{given.out} is no model file's name", "end it with .safetensors")
    selection = read_selection(given.selected, given.stage)
    with Bank(given.bank_file) as bank:
        scenarios = scenarios_of(selection, bank)
    hard = [] if given.validation is None else disjoint(corpus_set(given.validation, given.split), Known.of(scenarios))
    command = call_again(always=("policy", "stage", "seed"), with_places=False)
    origin = TuningOrigin(selection.digest, _digest(given.bank_file), command)
    choose_torch_device("cpu", 1)
    with stages() as report:
        repaired = few_shot_repair(
            find_model(given.policy),
            scenarios,
            settings,
            given.seed,
            given.out,
            validation=hard,
            origin=origin,
            labour=Labour(given.workers, report),
        )
    if given.as_json:
        click.echo(json.dumps({**asdict(repaired), "path": str(given.out)}, indent=2))
        return
    _show(repaired, len(scenarios))


def _show(repaired: FewShotRepair, count: int) -> None:
    rows = [["epochs", "of their change", "Driving Score", "of ordinary scenarios", "kept"]]
    for trial in repaired.trials:
        mark = "kept" if trial == repaired.kept else ""
        scores = ("-" if each is None else f"{each:.1f}" for each in (trial.driving_score, trial.ordinary))
        rows.append([str(trial.epochs), f"{100 * trial.share:.0f} %" if trial.epochs else "-", *scores, mark])
    show_rows(rows)
    arrived = sum(outcome == EventKind.GOAL.name for outcome in repaired.outcomes)
    shown = f"{arrived} of {len(repaired.outcomes)} demonstrations reached their goal"
    click.echo(f"{repaired.path}: {repaired.scenes} scenes of {count} scenarios; {shown}")
    if not repaired.kept.epochs:
        click.echo("no epoch was better than the policy as it was: the weights have not changed")


def _digest(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
