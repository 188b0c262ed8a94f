"""``roadmend train policy``: the neural policies by imitation of the privileged expert."""

import shutil
from pathlib import Path

import click

from roadmend.cli.options import WORKERS
from roadmend.cli.output import stages
from roadmend.core.errors import InputError
from roadmend.core.resources import config_folder
from roadmend.core.whole_file import written_beside
from roadmend.policies.neural_kinds import KINDS
from roadmend.training.dagger import Training
from roadmend.training.device import choose_torch_device
from roadmend.training.imitation_configuration import read_imitation_configuration

_SETTINGS = "policy-{kind}.yaml"


@click.command()
@click.option("--out", required=True, type=click.Path(path_type=Path, dir_okay=False), help="Model file to write.")
@click.option("--kind", default="neural", show_default=True, type=click.Choice([*KINDS]), help="Of policy.")
@click.option("--seed", default=0, show_default=True, type=click.IntRange(0, 10_000))
@click.option(
    "--config",
    "file",
    type=click.Path(path_type=Path, dir_okay=False),
    help="YAML file with the hyper-parameters; that of the kind in config/training if not given.",
)
@click.option("--rounds", type=click.IntRange(1, 50), help="Only the first so many rounds.")
@click.option("--episodes", type=click.IntRange(1, 900), help="New episodes of each family in every round.")
@WORKERS
@click.option("--device", default="auto", show_default=True, help="auto, cpu or cuda.")
@click.option("--resume", is_flag=True, help="Go on with an interrupted training of the same settings.")
def policy(
    out: Path,
    kind: str,
    seed: int,
    file: Path | None,
    rounds: int | None,
    episodes: int | None,
    workers: int,
    device: str,
    *,
    resume: bool,
) -> None:
    """Train a neural policy: behaviour cloning of the expert, then rounds of DAgger.

    What the rounds make is kept beside the model file, in NAME.rounds, and TensorBoard's logs with it.
    """
    given = file or config_folder() / "training" / _SETTINGS.format(kind=kind)
    configuration = read_imitation_configuration(given)
    if configuration.kind != kind:
        raise InputError(
            str(given), f"trains a policy of the kind {configuration.kind!r}", f"give --kind {configuration.kind}"
        )
    chosen = configuration.rounds[: rounds or len(configuration.rounds)]
    if episodes is not None:
        chosen = tuple(step.model_copy(update={"episodes": episodes}) for step in chosen)
    configuration = configuration.model_copy(update={"rounds": chosen})
    folder = out.with_name(f"{out.stem}.rounds")
    if folder.exists() and not resume:
        raise InputError(str(folder), "holds a training already", "go on with --resume, or give another --out")
    command = f"./roadmend train policy --kind {kind} --out {out.name} --seed {seed}"
    command += f" --rounds {rounds}" if rounds else ""
    command += f" --episodes {episodes}" if episodes else ""
    with stages() as report:
        # One thread: small batches gain little from more, and the bits are the same on every machine.
        training = Training(configuration, seed, folder, workers, choose_torch_device(device, 1), command, report)
        last = training.run()
    with written_beside(out) as beside:
        shutil.copyfile(last, beside)
    click.echo(f"{out}: trained in {len(chosen)} round{'s' if len(chosen) > 1 else ''}")
