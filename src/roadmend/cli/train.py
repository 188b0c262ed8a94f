"""``roadmend train policy`` and ``roadmend train adreft``: the networks that ship with the project, or your own."""

import json
import shutil
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any

import click

from roadmend.cli.call import call_again
from roadmend.cli.command import ExampleCommand
from roadmend.cli.driver_options import POLICY, POLICY_CORPUS, POLICY_NAME
from roadmend.cli.options import (
    DEVICE,
    FILE,
    FOLDER,
    JSON,
    MODEL_OUT,
    SEED,
    WORKERS,
    Number,
    options_of,
    setting_option,
    settings_file,
)
from roadmend.cli.output import told_stages
from roadmend.core.bounds import ARGUMENT
from roadmend.core.errors import InputError
from roadmend.core.fanout import fan_out
from roadmend.core.resources import config_folder
from roadmend.core.whole_file import written_beside
from roadmend.core.yaml_file import parse_yaml
from roadmend.networks.checkpoint import load_checkpoint
from roadmend.policies.neural_kinds import KINDS
from roadmend.repair.adreft.configuration import read_configuration
from roadmend.repair.adreft.model import KIND
from roadmend.training.adreft.ablations import ABLATIONS, ablated
from roadmend.training.adreft.adjusting import adjust as adjust_model
from roadmend.training.adreft.configuration import read_training_configuration
from roadmend.training.adreft.consistency import check_configuration
from roadmend.training.adreft.pipeline import Only, Pipeline, Trained, open_work
from roadmend.training.adreft.stage import RepairedPolicy, TrainingSubject
from roadmend.training.dagger import Training
from roadmend.training.device import choose_torch_device
from roadmend.training.imitation_configuration import LAST_SEED, read_imitation_configuration
from roadmend.world.corpus import Corpus, corpus_of

_SETTINGS = "policy-{kind}.yaml"


@dataclass(frozen=True)
class PolicyOptions:
    """Which kind of policy, how it is trained, and where it goes."""

    out: Annotated[Path, MODEL_OUT]
    kind: Annotated[
        str, click.option("--kind", default="neural", show_default=True, type=click.Choice([*KINDS]), help="Of policy.")
    ]
    seed: Annotated[int, click.option("--seed", default=0, show_default=True, type=click.IntRange(0, LAST_SEED))]
    file: Annotated[
        Path | None,
        settings_file("YAML file with the hyper-parameters; that of the kind in config/training if not given."),
    ]
    rounds: Annotated[
        int | None, click.option("--rounds", type=click.IntRange(1, 50), help="Only the first so many rounds.")
    ]
    episodes: Annotated[
        int | None,
        click.option("--episodes", type=click.IntRange(1, 900), help="New episodes of each family in every round."),
    ]
    workers: Annotated[int, WORKERS]
    device: Annotated[str, DEVICE]
    resume: Annotated[
        bool, click.option("--resume", is_flag=True, help="Go on with an interrupted training of the same settings.")
    ]
    as_json: Annotated[bool, JSON]


@click.command(
    cls=ExampleCommand, examples=["roadmend train policy --out my-policy.safetensors --workers 4"], resumes="--resume"
)
@options_of(PolicyOptions)
def policy(given: PolicyOptions) -> None:
    """Train a neural policy: behaviour cloning of the expert, then rounds of DAgger.

    What the rounds make is kept beside the model file, in NAME.rounds, and TensorBoard's logs with it.
    """
    path = given.file or config_folder() / "training" / _SETTINGS.format(kind=given.kind)
    configuration = read_imitation_configuration(path)
    if configuration.kind != given.kind:
        raise InputError(
            str(path), f"trains a policy of the kind {configuration.kind!r}", f"give --kind {configuration.kind}"
        )
    chosen = configuration.rounds[: given.rounds or len(configuration.rounds)]
    if given.episodes is not None:
        chosen = tuple(step.model_copy(update={"episodes": given.episodes}) for step in chosen)
    configuration = configuration.model_copy(update={"rounds": chosen})
    folder = given.out.with_name(f"{given.out.stem}.rounds")
    if folder.exists() and not given.resume:
        raise InputError(str(folder), "holds a training already", "go on with --resume, or give another --out")
    command = call_again(always=("kind", "seed"), with_places=False)
    with told_stages() as report:
        # One thread: small batches gain little from more, and the bits are the same on every machine.
        training = Training(
            configuration, given.seed, folder, given.workers, choose_torch_device(given.device, 1), command, report
        )
        last = training.run()
    with written_beside(given.out) as beside:
        shutil.copyfile(last, beside)
    if given.as_json:
        click.echo(json.dumps({"model": str(given.out), "rounds": len(chosen)}))
    else:
        click.echo(f"{given.out}: trained in {len(chosen)} round{'s' if len(chosen) > 1 else ''}")


@dataclass(frozen=True)
class AdreftOptions:
    """What is trained on, how, and where it goes."""

    policy: Annotated[str, POLICY]
    corpus_file: Annotated[Path | None, POLICY_CORPUS]
    file: Annotated[
        Path | None,
        settings_file("YAML file with the hyper-parameters; config/training/adreft.yaml if not given."),
    ]
    also: Annotated[
        tuple[str, ...],
        click.option(
            "--also",
            type=POLICY_NAME,
            multiple=True,
            help="Practise on the trials of this policy too, on the training cases of its own corpus; may be repeated.",
        ),
    ]
    settings: Annotated[
        tuple[str, ...],
        setting_option("Hyper-parameter in the place of the file's", "SECTION.NAME=VALUE"),
    ]
    out: Annotated[Path, MODEL_OUT]
    seed: Annotated[int, SEED]
    device: Annotated[str, DEVICE]
    workers: Annotated[int, WORKERS]
    only: Annotated[
        Only, click.option("--only", type=click.Choice(["supervised", "reinforcement"]), help="One of the two stages.")
    ]
    start: Annotated[
        Path | None,
        click.option(
            "--start",
            type=FILE,
            help="Model file to fine-tune, in place of the supervised stage; its need and change monitors are left out, "
            "and its rules of deciding and threshold are made anew.",
        ),
    ]
    ablation: Annotated[
        str | None,
        click.option(
            "--ablation",
            type=click.Choice([*ABLATIONS]),
            help="Leave something out: the adapter (rand_r), a stage (only_sl, only_rl), the step reward (wo_sr), "
            "nearness in the labels (wo_regulation).",
        ),
    ]
    work: Annotated[
        Path | None,
        click.option(
            "--work",
            type=FOLDER,
            help="Folder for frames, states and TensorBoard's logs; NAME.training beside the model file if not given.",
        ),
    ]
    resume: Annotated[
        bool | None,
        click.option(
            "--resume/--restart",
            "resume",
            default=None,
            help="Go on with an interrupted training of the same settings, or begin it anew; frames are kept either way.",
        ),
    ]
    as_json: Annotated[bool, JSON]


@click.command(
    cls=ExampleCommand,
    examples=["roadmend train adreft --policy modular --out my-repair.safetensors --set practice.dose=0.1"],
    resumes="--resume",
)
@options_of(AdreftOptions)
def adreft(given: AdreftOptions) -> None:
    """Train ADReFT for one policy, by the stages that the configuration has.

    These are a supervised stage on weak labels, as in the paper, or practice in its place, and reinforcement
    fine-tuning in closed loop.

    The same settings give the same model, whatever the number of workers and interruptions. The test split is never
    looked at; what is said at the end was measured on the validation split.
    """
    begin = time.perf_counter()
    configuration = read_training_configuration(
        given.file or config_folder() / "training" / "adreft.yaml", dict(map(setting, given.settings))
    )
    only = given.only
    if given.ablation is not None:
        only, configuration = ablated(configuration, given.ablation, only)
    if given.also and not configuration.practice.epochs:
        raise InputError("--also", "nothing is practised by this configuration", "leave it out, or set practice.epochs")
    if given.policy in given.also:
        raise InputError("--also", f"'{given.policy}' is the policy itself", "name another one")
    check_configuration(configuration, only)  # before a folder is made
    if given.start is not None:
        _tell_what_is_left_out(given.start)
    corpus = corpus_of(given.policy, given.corpus_file)
    work = given.work or given.out.with_name(f"{given.out.stem}.training")
    open_work(work, resume=given.resume, keep_supervised=only == "reinforcement")
    validation = corpus.select(split="validation")
    subject = TrainingSubject(driver_of(corpus), validation, [driver_of(corpus_of(other)) for other in given.also])
    chosen = choose_torch_device(given.device, configuration.threads)
    with told_stages() as report, fan_out(given.workers) as mapper:
        pipeline = Pipeline(
            configuration, subject, seed=given.seed, device=chosen, mapper=mapper, work=work, report=report
        )
        trained = pipeline.run(given.out, only, given.start)
    seconds = time.perf_counter() - begin
    if given.as_json:
        figures = {"summary": asdict(trained.summary), "monitor": asdict(trained.monitor)}
        told = {"model": str(given.out), "seconds": seconds, "threshold": trained.threshold, **figures}
        click.echo(json.dumps(told, indent=2))
    else:
        _say(given.out, trained, seconds)


def _tell_what_is_left_out(start: Path) -> None:
    risks = read_configuration(str(start), load_checkpoint(start, KIND).header).risks
    if risks:
        what = f"its {' and '.join(risks)} monitor{'s are' if len(risks) > 1 else ' is'} left out"
        click.echo(f"{start}: {what}; './roadmend train need' and 'train changes' give others", err=True)


@click.command(
    cls=ExampleCommand,
    examples=["roadmend train adjust my-repair.safetensors --threshold 0.6 --out adjusted.safetensors"],
)
@click.argument("model", type=FILE)
@click.option("--threshold", type=Number(0.0, 1.0), help="Above which it steps in.  [default: as it is]")
@setting_option("Rule of deciding in the place of the model's: hold, clear, interval, longest, ...")
@MODEL_OUT
@JSON
def adjust(model: Path, threshold: float | None, settings: tuple[str, ...], out: Path, *, as_json: bool) -> None:
    """Write MODEL, one of ADReFT, with another threshold or other rules of deciding; its networks stay as they are."""
    changes = dict(setting(each, "NAME=VALUE", "hold=0.3") for each in settings)
    digest = adjust_model(model, out, threshold, changes, call_again(with_places=False))
    click.echo(json.dumps({"model": str(out), "sha256": digest}) if as_json else f"{out}: SHA-256 {digest}")


def setting(text: str, form: str = "SECTION.NAME=VALUE", example: str = "practice.dose=0.1") -> tuple[str, Any]:
    """The name and the value of ``SECTION.NAME=VALUE``, or of another form with as many points, as options have it.

    Raises:
        InputError: it is no such thing.
    """
    name, _, value = text.partition("=")
    try:
        if value and all(name.split(".")) and name.count(".") >= form.count("."):
            return name, parse_yaml(value, name, ARGUMENT)
    except InputError:
        pass
    raise InputError("--set", f"{text[:100]!r} is no {form}", f"write for instance {example}")


def driver_of(corpus: Corpus) -> RepairedPolicy:
    """Whose repair is learned from a corpus: from its training cases."""
    return RepairedPolicy(corpus.policy, corpus.model or "", corpus.digest, corpus.select(split="training"))


def _say(out: Path, trained: Trained, seconds: float) -> None:
    summary, monitor = trained.summary, trained.monitor
    click.echo(f"{out}: trained in {seconds / 60.0:.1f} min, threshold {trained.threshold:.4f}; on validation:")
    click.echo(
        f"  monitor: precision {100 * monitor.precision:.1f} %, recall {100 * monitor.recall:.1f} %, "
        f"F1 {100 * monitor.f1:.1f} %"
    )
    click.echo(
        f"  {summary.violations} violations: {summary.fix:.1f} % reach their goal, {summary.fix_loose:.1f} % do not "
        f"collide; dose {summary.dose:.2f} s"
    )
    click.echo(
        f"  {summary.successes} successes: {summary.deg:.1f} % collide, {summary.late:.1f} % do not reach their goal; "
        f"dose {summary.dose_success:.2f} s"
    )
    click.echo(
        f"  dE {summary.delta_e:.1f}, intensity {summary.intensity:.2f}, {summary.intervened_frames:.1f} % of the "
        f"frames intervened"
    )
