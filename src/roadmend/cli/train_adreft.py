"""``roadmend train adreft``: ADReFT for one policy, from a corpus to a model file."""

import time
from pathlib import Path
from typing import Any

import click
import yaml
from rich.progress import TextColumn

from roadmend.cli.options import WORKERS
from roadmend.cli.output import counting
from roadmend.core.errors import InputError
from roadmend.core.fanout import fan_out
from roadmend.core.resources import config_folder
from roadmend.policies.registry import POLICIES
from roadmend.training.adreft.configuration import TrainingConfiguration, read_training_configuration
from roadmend.training.adreft.pipeline import (
    PRACTICE_STATE,
    REINFORCEMENT_STATE,
    SUPERVISED_STATE,
    Only,
    Pipeline,
    Trained,
)
from roadmend.training.adreft.stage import RepairedPolicy, TrainingSubject
from roadmend.training.device import choose_torch_device
from roadmend.world.corpus import Corpus, corpus_of

_ABLATIONS: dict[str, tuple[Only, dict[str, dict[str, Any]]]] = {  # which stage alone, and what is set
    "rand_r": ("supervised", {"model": {"choice": "random"}}),
    "only_sl": ("supervised", {}),
    "only_rl": (None, {"reinforcement": {"start": "scratch"}}),
    "wo_sr": (None, {"reinforcement": {"step_reward": False}}),
    "wo_regulation": (None, {"frames": {"labels": "weak_without_regulation"}, "practice": {"near": 0.0}}),
    "wo_precaution": (None, {"model": {"weighing": {"gain": 0.0}}}),
}


@click.command()
@click.option("--policy", default="modular", show_default=True, type=click.Choice(sorted(POLICIES)))
@click.option(
    "--corpus",
    "corpus_file",
    type=click.Path(path_type=Path, dir_okay=False),
    help="The policy's corpus; config/corpora/POLICY.jsonl if not given.",
)
@click.option(
    "--config",
    "file",
    type=click.Path(path_type=Path, dir_okay=False),
    help="YAML file with the hyper-parameters; config/training/adreft.yaml if not given.",
)
@click.option(
    "--also",
    type=click.Choice(sorted(POLICIES)),
    multiple=True,
    help="Practise on the trials of this policy too, on the training cases of its own corpus; may be repeated.",
)
@click.option(
    "--set",
    "settings",
    multiple=True,
    metavar="SECTION.NAME=VALUE",
    help="Hyper-parameter in the place of the file's; may be repeated.",
)
@click.option("--out", required=True, type=click.Path(path_type=Path, dir_okay=False), help="Model file to write.")
@click.option("--seed", default=0, show_default=True, type=click.IntRange(0, 2**31 - 1))
@click.option("--device", default="auto", show_default=True, help="auto, cpu or cuda.")
@WORKERS
@click.option("--only", type=click.Choice(["supervised", "reinforcement"]), help="One of the two stages.")
@click.option(
    "--start",
    type=click.Path(path_type=Path, dir_okay=False),
    help="Model file to fine-tune, in place of the supervised stage.",
)
@click.option(
    "--ablation",
    type=click.Choice([*_ABLATIONS]),
    help="Leave something out: the adapter (rand_r), a stage (only_sl, only_rl), the step reward (wo_sr), "
    "nearness in the labels (wo_regulation), stepping in before the monitor alarms (wo_precaution).",
)
@click.option(
    "--work",
    type=click.Path(path_type=Path, file_okay=False),
    help="Folder for frames, states and TensorBoard's logs; NAME.training beside the model file if not given.",
)
@click.option(
    "--resume/--restart",
    "resume",
    default=None,
    help="Go on with an interrupted training of the same settings, or begin it anew; frames are kept either way.",
)
def adreft(
    policy: str,
    corpus_file: Path | None,
    file: Path | None,
    also: tuple[str, ...],
    settings: tuple[str, ...],
    out: Path,
    seed: int,
    device: str,
    workers: int,
    only: Only,
    start: Path | None,
    ablation: str | None,
    work: Path | None,
    *,
    resume: bool | None,
) -> None:
    """Train ADReFT for one policy, by the stages that the configuration has.

    These are a supervised stage on weak labels, as in the paper, or practice in its place, and reinforcement
    fine-tuning in closed loop.

    The same settings give the same model, whatever the number of workers and interruptions, as far as SUMO repeats
    itself: in rare episodes it does not, and fine-tuning goes on otherwise from there. The test split is never
    looked at; what is said at the end was measured on the validation split.
    """
    begin = time.perf_counter()
    configuration = read_training_configuration(
        file or config_folder() / "training" / "adreft.yaml", dict(map(_setting, settings))
    )
    if ablation is not None:
        only, changes = _ABLATIONS[ablation][0] or only, _ABLATIONS[ablation][1]
        if "weighing" in changes.get("model", {}) and configuration.model.weighing is None:
            mend = "leave it out, or give a configuration with model.weighing"
            raise InputError("--ablation", f"'{ablation}' changes prices, of which this configuration has none", mend)
        configuration = _changed(configuration, changes)
        if "reinforcement" in changes and not configuration.reinforcement.episodes:
            mend = "set reinforcement.episodes, or give --config config/training/adreft-paper.yaml"
            raise InputError(
                "--ablation", f"'{ablation}' changes fine-tuning, of which this configuration has none", mend
            )
    if also and not configuration.practice.epochs:
        raise InputError("--also", "nothing is practised by this configuration", "leave it out, or set practice.epochs")
    if policy in also:
        raise InputError("--also", f"'{policy}' is the policy itself", "name another one")
    corpus = corpus_of(policy, corpus_file)
    work = work or out.with_name(f"{out.stem}.training")
    _open_work(work, resume=resume, keep_supervised=only == "reinforcement")
    validation = corpus.select(split="validation")
    subject = TrainingSubject(_driver(corpus), validation, [_driver(corpus_of(other)) for other in also])
    chosen = choose_torch_device(device, configuration.threads)
    with counting(TextColumn("{task.fields[how]}")) as progress, fan_out(workers) as mapper:
        tasks: dict[str, Any] = {}

        def report(what: str, done: int, total: int, how: str) -> None:
            if what not in tasks:
                tasks[what] = progress.add_task(what, total=total, how=how)
            progress.update(tasks[what], completed=done, total=total, how=how)

        pipeline = Pipeline(configuration, subject, seed=seed, device=chosen, mapper=mapper, work=work, report=report)
        trained = pipeline.run(out, only, start)
    _say(out, trained, time.perf_counter() - begin)


def _setting(text: str) -> tuple[str, Any]:
    """The name and the value of ``SECTION.NAME=VALUE``.

    Raises:
        InputError: it is no such thing.
    """
    name, _, value = text.partition("=")
    try:
        if value and all(name.partition(".")):
            return name, yaml.safe_load(value)
    except yaml.YAMLError:
        pass
    raise InputError("--set", f"{text!r} is no SECTION.NAME=VALUE", "write for instance practice.dose=0.1")


def _driver(corpus: Corpus) -> RepairedPolicy:
    return RepairedPolicy(corpus.policy, corpus.model or "", corpus.digest, corpus.select(split="training"))


def _changed(configuration: TrainingConfiguration, changes: dict[str, dict[str, Any]]) -> TrainingConfiguration:
    return TrainingConfiguration.model_validate(_merged(configuration.model_dump(), changes))


def _merged(content: dict[str, Any], changes: dict[str, Any]) -> dict[str, Any]:
    """Some content with other values at the places that the changes name."""
    return content | {
        name: _merged(content[name], value) if isinstance(value, dict) else value for name, value in changes.items()
    }


def _open_work(work: Path, *, resume: bool | None, keep_supervised: bool) -> None:
    """Make the folder; states of an earlier training are gone on with or removed, as was asked for.

    Raises:
        InputError: there are such states and nothing was asked for, or the folder cannot be made.
    """
    states = [work / REINFORCEMENT_STATE]
    if not keep_supervised:
        states += [work / SUPERVISED_STATE, *sorted(work.glob(PRACTICE_STATE.format("*")))]
    found = [state for state in states if state.exists()]
    if found and resume is None:
        raise InputError(str(work), "holds a training already", "go on with --resume, or begin anew with --restart")
    try:
        for state in found if resume is False else ():
            state.unlink()
        work.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(str(work), f"cannot be written ({error.strerror})", "choose a writable folder") from None


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
