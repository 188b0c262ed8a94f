"""``roadmend train changes``: a model of ADReFT learns which lane changes must wait."""

import json
from dataclasses import asdict
from pathlib import Path

import click

from roadmend.cli.command import ExampleCommand
from roadmend.cli.driver_options import POLICY, POLICY_CORPUS, POLICY_NAME
from roadmend.cli.options import FILE, FOLDER, JSON, MODEL_OUT, SEED, WORKERS
from roadmend.cli.output import told_stages
from roadmend.cli.train import driver_of, setting
from roadmend.core.errors import InputError
from roadmend.core.fanout import fan_out
from roadmend.core.settings import check_settings
from roadmend.repair.adreft.model import AdreftModel
from roadmend.training.adreft.change_settings import ChangeSettings
from roadmend.training.adreft.change_training import LearnedChanges, train_changes
from roadmend.world.corpus import corpus_of


@click.command(
    cls=ExampleCommand,
    examples=["roadmend train changes my-repair.safetensors --policy modular --also neural --out careful.safetensors"],
    resumes="",
)
@click.argument("model", type=FILE)
@POLICY
@POLICY_CORPUS
@click.option("--also", type=POLICY_NAME, multiple=True, help="Learn from this policy's changes too; may be repeated.")
@click.option(
    "--set",
    "settings",
    multiple=True,
    metavar="NAME=VALUE",
    help="Hyper-parameter: epochs, held, ...; may be repeated.",
)
@MODEL_OUT
@SEED
@WORKERS
@click.option(
    "--work", type=FOLDER, help="Folder for what was driven; NAME.changes beside the model file if not given."
)
@JSON
def changes(
    model: Path,
    policy: str,
    corpus_file: Path | None,
    also: tuple[str, ...],
    settings: tuple[str, ...],
    out: Path,
    seed: int,
    workers: int,
    work: Path | None,
    *,
    as_json: bool,
) -> None:
    """Give MODEL, one of ADReFT, a monitor of lane changes; its other networks stay as they are.

    The policy, under repair by MODEL, drives the training cases with lane changes and random scenarios; which of the
    changes that it begins end in a collision of its own making is what the monitor learns. The test split is never
    looked at.
    """
    if policy in also:
        raise InputError("--also", f"'{policy}' is the policy itself", "name another one")
    given = {name.removeprefix("changes."): value for name, value in (setting(f"changes.{each}") for each in settings)}
    read = check_settings(given, ChangeSettings, "--set", "see ./roadmend train changes --help")
    AdreftModel.load(model)  # a file that is none is refused before anybody starts to drive
    drivers = [driver_of(corpus_of(policy, corpus_file)), *(driver_of(corpus_of(other)) for other in also)]
    command = f"./roadmend train changes {model.name} --policy {policy}"
    command += "".join(f" --also {other}" for other in also) + "".join(f" --set {each}" for each in settings)
    with told_stages() as report, fan_out(workers) as mapper:
        learned = train_changes(
            model,
            out,
            drivers,
            read,
            seed=seed,
            mapper=mapper,
            work=work or out.with_name(f"{out.stem}.changes"),
            command=command,
            report=report,
        )
    if as_json:
        click.echo(json.dumps({"model": str(out), **asdict(learned)}, indent=2))
    else:
        _say(out, learned)


def _say(out: Path, learned: LearnedChanges) -> None:
    click.echo(f"{out}: learned from {learned.changes} lane changes, {learned.collided} of which ended badly")
    separation = "none" if learned.separation is None else f"{learned.separation:.3f}"
    caught = "none" if learned.caught is None else f"{100.0 * learned.caught:.0f} %"
    click.echo(
        f"  validation: {learned.validation_changes} changes, {learned.validation_collided} end badly; separation "
        f"{separation}; threshold {learned.threshold:.3f} holds back {caught} of those"
    )
