"""``roadmend train need`` and ``train changes``: a model of ADReFT learns where to step in, and what must wait."""

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated

import click

from roadmend.cli.call import call_again
from roadmend.cli.command import ExampleCommand
from roadmend.cli.driver_options import POLICY, POLICY_CORPUS, POLICY_NAME
from roadmend.cli.options import FILE, FOLDER, JSON, MODEL_OUT, SEED, WORKERS, options_of, setting_option
from roadmend.cli.output import told_stages
from roadmend.cli.train import driver_of, setting
from roadmend.core.errors import InputError
from roadmend.core.fanout import fan_out
from roadmend.core.settings import check_settings
from roadmend.repair.adreft.model import AdreftModel
from roadmend.search.policy_model import policy_model
from roadmend.training.adreft.risk_training import KINDS, LearnedRisks, RiskKind, train_risk_monitor
from roadmend.training.adreft.stage import RepairedPolicy
from roadmend.world.corpus import corpus_of, has_corpus


@dataclass(frozen=True)
class MonitorOptions:
    """What is learned from, how, and where it goes."""

    model: Annotated[Path, click.argument("model", type=FILE)]
    policy: Annotated[str, POLICY]
    corpus_file: Annotated[Path | None, POLICY_CORPUS]
    also: Annotated[
        tuple[str, ...],
        click.option(
            "--also",
            type=POLICY_NAME,
            multiple=True,
            help="Learn of this policy's drives too, of random ones alone where no corpus ships; repeatable.",
        ),
    ]
    settings: Annotated[
        tuple[str, ...],
        setting_option("Hyper-parameter: epochs, false_alarms, ..."),
    ]
    out: Annotated[Path, MODEL_OUT]
    seed: Annotated[int, SEED]
    workers: Annotated[int, WORKERS]
    work: Annotated[
        Path | None,
        click.option(
            "--work", type=FOLDER, help="Folder for what was driven; NAME.drives beside the model file if not given."
        ),
    ]
    as_json: Annotated[bool, JSON]


@click.command(
    cls=ExampleCommand,
    examples=["roadmend train need my-repair.safetensors --policy modular --out needed.safetensors"],
    resumes="",
)
@options_of(MonitorOptions)
def need(given: MonitorOptions) -> None:
    """Give MODEL, one of ADReFT, a monitor of need; its other networks stay as they are.

    The policy alone drives the training cases and random scenarios; of the moments at which MODEL finds a scene
    critical, the monitor learns which end in a collision of the policy's own making if nobody steps in. An intervention
    then begins only where it is needed. The test split is never looked at.
    """
    _train("need", given)


@click.command(
    cls=ExampleCommand,
    examples=["roadmend train changes my-repair.safetensors --policy modular --also neural --out careful.safetensors"],
    resumes="",
)
@options_of(MonitorOptions)
def changes(given: MonitorOptions) -> None:
    """Give MODEL, one of ADReFT, a monitor of lane changes; its other networks stay as they are.

    The policy, under repair by MODEL, drives the training cases with lane changes and random scenarios; which of the
    changes that it begins end in a collision of its own making is what the monitor learns. The test split is never
    looked at.
    """
    _train("changes", given)


def _train(name: str, given: MonitorOptions) -> None:
    kind = KINDS[name]
    if given.policy in given.also:
        raise InputError("--also", f"'{given.policy}' is the policy itself", "name another one")
    named = dict(setting(each, "NAME=VALUE", "epochs=3") for each in given.settings)
    read = check_settings(named, kind.settings, "--set", f"see ./roadmend train {name} --help")
    AdreftModel.load(given.model)  # a file that is none is refused before anybody starts to drive
    drivers = [driver_of(corpus_of(given.policy, given.corpus_file)), *map(_driver_beside, given.also)]
    command = call_again(always=("policy", "seed"), with_places=False)
    with told_stages() as report, fan_out(given.workers) as mapper:
        learned = train_risk_monitor(
            kind,
            given.model,
            given.out,
            drivers,
            read,
            seed=given.seed,
            mapper=mapper,
            work=given.work or given.out.with_name(f"{given.out.stem}.drives"),
            command=command,
            report=report,
        )
    if given.as_json:
        click.echo(json.dumps({"model": str(given.out), **asdict(learned)}, indent=2))
    else:
        _say(given.out, kind, learned)


def _driver_beside(policy: str) -> RepairedPolicy:
    """A further policy, with its training cases where a corpus of it ships."""
    if has_corpus(policy):
        return driver_of(corpus_of(policy))
    return RepairedPolicy(policy, policy_model(policy) or "", "", ())


def _say(out: Path, kind: RiskKind, learned: LearnedRisks) -> None:
    click.echo(f"{out}: learned from {learned.judged} {kind.what}, {learned.collided} of which ended badly")
    separation = "none" if learned.separation is None else f"{learned.separation:.3f}"
    caught = "none" if learned.caught is None else f"{100.0 * learned.caught:.0f} %"
    click.echo(
        f"  validation: {learned.validation_judged} {kind.what}, {learned.validation_collided} end badly; separation "
        f"{separation}; {caught} of those are above the threshold {learned.threshold:.3f}"
    )
