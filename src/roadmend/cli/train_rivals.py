"""``roadmend train self-oracle`` and ``roadmend train rivals``: what ADReFT is held against, at its best."""

import json
from pathlib import Path

import click
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from roadmend import __version__
from roadmend.cli.call import call_again
from roadmend.cli.command import ExampleCommand
from roadmend.cli.driver_options import POLICY, POLICY_CORPUS
from roadmend.cli.options import FILE, JSON, MODEL_OUT, SEED, WORKERS, only_own
from roadmend.cli.output import counting, stages_of
from roadmend.core.fanout import fan_out
from roadmend.core.journal import Journal
from roadmend.measures.driver import driver_key
from roadmend.networks.checkpoint import SUFFIX, load_checkpoint, models_folder
from roadmend.repair.self_oracle import KIND
from roadmend.training.tuned_file import first_cases, read_tuned, write_tuned
from roadmend.training.tuning import EPISODES, FORMAT, TunedRival, Tuning
from roadmend.training.tuning_grid import Rival, rivals_of
from roadmend.world.corpus import corpus_of

_RIVALS = tuple(rival.name for rival in rivals_of(""))


@click.command(
    "self-oracle",
    cls=ExampleCommand,
    examples=["roadmend train self-oracle --policy modular --out self_oracle.safetensors"],
)
@POLICY
@POLICY_CORPUS
@MODEL_OUT
@SEED
@click.option("--epochs", default=100, show_default=True, type=click.IntRange(1, 10_000))
@WORKERS
@JSON
def self_oracle(
    policy: str, corpus_file: Path | None, out: Path, seed: int, epochs: int, workers: int, *, as_json: bool
) -> None:
    """Train the autoencoder of ModelRepair on the successes of the training split.

    The same settings give the same file, whatever the number of workers.
    """
    from roadmend.networks.checkpoint import save_checkpoint  # noqa: PLC0415 - torch is for this command alone
    from roadmend.training.self_oracle import (  # noqa: PLC0415
        SelfOracleSettings,
        gather_vectors,
        train_self_oracle,
    )

    corpus = corpus_of(policy, corpus_file)
    settings = SelfOracleSettings(seed=seed, epochs=epochs)
    cases = corpus.select(split="training", violation=False)
    with counting() as progress:
        driving = progress.add_task("driving", total=len(cases))
        learning = progress.add_task("learning", total=epochs)
        with fan_out(workers, len(cases)) as mapper:
            vectors = gather_vectors(cases, policy, settings.stride, mapper, lambda: progress.advance(driving))

        def report(epoch: int, loss: float) -> None:
            progress.update(learning, completed=epoch, description=f"learning, loss {loss:.4f}")

        result = train_self_oracle(vectors, settings, report)
    command = call_again(always=("policy", "seed", "epochs"), with_places=False)
    origin = {"policy": policy, "policy_model": corpus.model, "roadmend": __version__, "command": command}
    save_checkpoint(out, result.tensors, result.header(settings, corpus.digest, **origin))
    metrics = result.metrics
    if as_json:
        click.echo(json.dumps({"model": str(out), **metrics}, indent=2))
        return
    click.echo(
        f"{out}: {metrics['training_frames']:.0f} frames, error on held-out frames {metrics['held_out_loss']:.3f}, "
        f"{100.0 * metrics['held_out_alarms_at_0.05']:.1f} % of them alarm at a rate of 5 %"
    )


@click.command(
    cls=ExampleCommand, examples=["roadmend train rivals --policy modular --out rivals.yaml --only rss"], resumes=""
)
@POLICY
@POLICY_CORPUS
@click.option("--out", required=True, type=FILE, callback=only_own, help="YAML file to write.")
@click.option("--only", multiple=True, type=click.Choice(_RIVALS), help="Only these rivals; may be repeated.")
@click.option(
    "--cases",
    "number",
    type=click.IntRange(1, 10_000),
    help="Only the first so many validation cases of each family and kind.",
)
@click.option(
    "--model", "model_file", type=FILE, help="SelfOracle model; the one that ships for the policy if not given."
)
@WORKERS
@JSON
def rivals(
    policy: str,
    corpus_file: Path | None,
    out: Path,
    only: tuple[str, ...],
    number: int | None,
    model_file: Path | None,
    workers: int,
    *,
    as_json: bool,
) -> None:
    """Find every rival's best setting on the validation split.

    Every setting of a rival's grid drives a third of the cases, the best four drive all; the largest dE wins, of
    equals the least intensity. Episodes are kept beside the file, in NAME.tuning: the same command goes on where it was
    interrupted. Rivals that are not asked for keep what an earlier call of the same kind has written.
    """
    corpus = corpus_of(policy, corpus_file)
    every = rivals_of(str(model_file) if model_file else policy)
    chosen = [rival for rival in every if not only or rival.name in only]
    model = ""
    if any(rival.method == "model" for rival in chosen):
        model = load_checkpoint(model_file or models_folder() / f"self_oracle-{policy}{SUFFIX}", KIND).digest
    cases = first_cases(corpus.select(split="validation"), number)
    header = {
        "format": FORMAT,
        "policy": policy,
        "policy_model": corpus.model,
        "corpus": corpus.digest,
        "split": "validation",
        "cases": len(cases),
        "roadmend": __version__,
    }
    command = call_again(always=("policy",), with_places=False)  # of a rival each: a file may come of several calls
    written = read_tuned(out, header)
    left = [rival for rival in every if rival not in chosen and rival.name in written]
    found = {
        rival.name: written[rival.name] for rival in left if written[rival.name].get("code") == _code(policy, rival)
    }
    identity = {"policy": policy, "corpus": corpus.digest}
    with counting() as progress, fan_out(workers) as mapper:
        report = stages_of(progress)
        for rival in chosen:
            of_model = {"model": model} if rival.method == "model" else {}
            file = out.with_name(f"{out.stem}.tuning") / f"{rival.name}.jsonl"
            with Journal(file, EPISODES, identity | of_model) as journal:
                tuned = Tuning(cases, policy, journal, mapper, report).tune(rival)
            found[rival.name] = tuned.dump() | ({"model_digest": model} if rival.method == "model" else {})
            found[rival.name] |= {"code": _code(policy, rival), "command": command}
            if rival.method == "model" and model_file is not None:
                found[rival.name]["parameters"]["model"] = policy  # a setting holds wherever the model lies
            write_tuned(out, header, found)
            _show(tuned, progress.console)
    click.echo(json.dumps({"file": str(out), "rivals": found}, indent=2) if as_json else f"{out}: {', '.join(found)}")


def _code(policy: str, rival: Rival) -> str:
    """Digest of what drove when a rival was tuned, its setting aside."""
    return driver_key(policy, rival.method, rival.grid[0])


def _show(tuned: TunedRival, console: Console) -> None:
    table = Table("", *tuned.points[0].parameters, "part dE", "dE", "%Fix", "%Deg", "intensity", "dose", box=None)
    for index, point in enumerate(tuned.points):
        whole = point.whole
        figures = (whole.delta_e, whole.fix, whole.deg, whole.intensity, whole.dose) if whole is not None else ()
        table.add_row(
            tuned.name if index == tuned.best else "",
            *(escape(str(value)) for value in point.parameters.values()),
            f"{point.first.delta_e:.1f}",
            *(f"{value:.2f}" for value in figures),
            style="bold" if index == tuned.best else None,
        )
    console.print(table)
