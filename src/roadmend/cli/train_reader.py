"""``roadmend train reader``: the network that reads crash reports beside the rules."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import click

from roadmend import __version__
from roadmend.cli.call import call_again
from roadmend.cli.command import ExampleCommand
from roadmend.cli.options import DEVICE, FILE, FOLDER, JSON, MODEL_OUT, SEED, WORKERS, options_of, settings_file
from roadmend.cli.output import told_stages
from roadmend.core.fanout import fan_out
from roadmend.core.resources import config_folder
from roadmend.core.settings import read_settings
from roadmend.networks.checkpoint import save_checkpoint

_SETTINGS = "crash-text.yaml"


@dataclass(frozen=True)
class ReaderOptions:
    """What is learned from, how, and where it goes."""

    told: Annotated[tuple[Path, ...], click.argument("told", nargs=-1, required=True, type=FILE)]
    encoder: Annotated[
        Path,
        click.option(
            "--encoder",
            required=True,
            type=FOLDER,
            help="Folder of the BERT encoder to begin from: config.json, vocab.txt or tokenizer.json, model.safetensors.",
        ),
    ]
    out: Annotated[Path, MODEL_OUT]
    file: Annotated[
        Path | None,
        settings_file("YAML file with the hyper-parameters; config/training/crash-text.yaml if not given."),
    ]
    seed: Annotated[int, SEED]
    work: Annotated[
        Path | None,
        click.option(
            "--work",
            type=FOLDER,
            help="Folder for the state of the training; NAME.training beside the model file if not given.",
        ),
    ]
    threads: Annotated[
        int,
        click.option("--threads", default=2, show_default=True, type=click.IntRange(1, 256), help="Of the processor."),
    ]
    device: Annotated[str, DEVICE]
    workers: Annotated[int, WORKERS]
    as_json: Annotated[bool, JSON]


@click.command(
    cls=ExampleCommand,
    examples=[
        "roadmend train reader config/crashes/told-crashes.jsonl --encoder all-MiniLM-L6-v2 --out reader.safetensors"
    ],
    resumes="",
)
@options_of(ReaderOptions)
def reader(given: ReaderOptions) -> None:
    """Train the network that reads crash reports beside the rules.

    TOLD are crashes with keys: JSON Lines, or texts with NAME.oracle.json beside them. It begins with made-up crashes,
    learns from the told ones, and is measured on those of authors that the configuration holds out. The state is kept
    after every epoch: the same command goes on where it was interrupted. The device and the number of threads decide the last bits.
    """
    from roadmend.safe.trained.schooling import Schooling, school  # noqa: PLC0415 - torch is for this command alone
    from roadmend.safe.trained.told_crashes import read_told  # noqa: PLC0415
    from roadmend.training.device import choose_torch_device  # noqa: PLC0415

    settings = read_settings(given.file or config_folder() / "training" / _SETTINGS, Schooling, "mend the file")
    told = [crash for path in given.told for crash in read_told(path)]
    work = given.work or given.out.with_name(f"{given.out.stem}.training")
    device = choose_torch_device(given.device, given.threads)
    with told_stages() as report, fan_out(given.workers, len(told)) as mapper:

        def watch(stage: str, done: int, of: int, loss: float) -> None:
            report(stage, done, of, f"loss {loss:.2f}" if loss else "")

        schooled = school(told, given.encoder, settings, given.seed, work, mapper, watch, device)
    header = {
        **schooled.header,
        "kind": "crash_text",
        "roadmend": __version__,
        "command": call_again(always=("seed", "threads"), with_places=False),
    }
    save_checkpoint(given.out, schooled.tensors, header)
    metrics = schooled.header["metrics"]
    if given.as_json:
        click.echo(json.dumps({"model": str(given.out), **metrics}, indent=2))
        return
    shares = ", ".join(f"{name} {100 * value:.0f} %" for name, value in metrics.items() if isinstance(value, float))
    click.echo(f"{given.out}: {metrics['lessons']} lessons; right on {metrics['held_out']} texts held out: {shares}")
