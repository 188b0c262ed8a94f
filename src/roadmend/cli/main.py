"""The command ``roadmend``."""

import errno
import os
import shlex
import sys
import sysconfig
from collections.abc import Sequence
from pathlib import Path

import click

from roadmend import __version__
from roadmend.cli.command import called_as, is_clone
from roadmend.cli.completion import VARIABLE
from roadmend.cli.lazy import LazyGroup, Table
from roadmend.core.errors import InputError, RoadmendError
from roadmend.core.extras import extra_missing
from roadmend.core.interrupt import InterruptedWorkError

_NO_ROOM = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}
_NO_PLACE = {errno.ENAMETOOLONG, errno.EACCES, errno.EPERM, errno.ELOOP, errno.ENOTDIR, errno.EISDIR, errno.EROFS}
_BAG: Table = {
    "info": ("roadmend.cli.bag", "bag_info", "Topics, rates, gaps, outcome, interventions; is it complete?"),
    "recover": ("roadmend.cli.bag", "bag_recover", "What a cut or damaged bag still holds, as a new bag."),
    "diff": ("roadmend.cli.bag", "bag_diff", "Two bags, tick by tick."),
    "convert": ("roadmend.cli.bag", "bag_convert", "From mcap to sqlite3 and back."),
    "plot": ("roadmend.cli.bag_plot", "plot", "Draw its time line, with the scene at one moment."),
    "shadow": ("roadmend.cli.bag_shadow", "shadow", "Ask another repair method what it would have done at every tick."),
    "resimulate": ("roadmend.cli.bag_repair", "resimulate", "Drive a bag's scenario again with another method."),
    "need": ("roadmend.cli.bag_need", "need", "Which interventions of a run were rescues, and which a nuisance."),
}
_SAFE: Table = {
    "extract": ("roadmend.cli.safe", "extract", "Read crash reports: what happened, in the scenario language."),
    "build": ("roadmend.cli.safe", "build", "Build the scenarios of crash reports."),
    "test": ("roadmend.cli.safe", "safe_test", "Drive the scenarios of crash reports with a policy."),
    "reproduce": ("roadmend.cli.safe", "reproduce", "Search for the crash that a report describes."),
    "export": ("roadmend.cli.safe", "export", "Write a scenario as ASAM OpenSCENARIO and OpenDRIVE."),
}
_SERA: Table = {
    "bank": ("roadmend.cli.sera_bank", "bank", "Build, show, search, export and import a scenario bank."),
    "evaluate": (
        "roadmend.cli.sera_evaluate",
        "evaluate",
        "Drive an evaluation set: four measures, and bags of failures.",
    ),
    "analyse": ("roadmend.cli.sera", "analyse_bags", "Find the failures in bags, and the patterns in them."),
    "recommend": ("roadmend.cli.sera", "recommend", "Select scenarios to learn from."),
    "tune": ("roadmend.cli.sera_tune", "tune", "Fine-tune a neural policy on a selection."),
    "cycle": ("roadmend.cli.sera_cycle", "cycle", "Run several generations of all this, and plot them."),
}
_TRAIN: Table = {
    "policy": ("roadmend.cli.train", "policy", "A neural driving policy, by imitation of the expert."),
    "adreft": ("roadmend.cli.train", "adreft", "ADReFT for one policy, from its corpus."),
    "adjust": ("roadmend.cli.train", "adjust", "A model of ADReFT with another threshold, its networks as they are."),
    "need": ("roadmend.cli.train_monitors", "need", "A monitor of need for a model of ADReFT."),
    "changes": ("roadmend.cli.train_monitors", "changes", "A monitor of lane changes for a model of ADReFT."),
    "self-oracle": ("roadmend.cli.train_rivals", "self_oracle", "The autoencoder of the rival ModelRepair."),
    "reader": ("roadmend.cli.train_reader", "reader", "The network that reads crash reports beside the rules."),
    "rivals": ("roadmend.cli.train_rivals", "rivals", "The rivals' best settings on the validation split."),
}


@click.group(
    cls=LazyGroup,
    table=_BAG,
    examples=["roadmend bag info bags/my-run", "roadmend bag plot bags/my-run --out my-run.html"],
)
def bag() -> None:
    """Look into bags, mend them, compare them.

    BAG is a bag's folder, its metadata.yaml, or an .mcap file by itself.
    """


@click.group(
    cls=LazyGroup,
    table=_SAFE,
    examples=["roadmend safe extract reports --out read", "roadmend safe test reports --policy modular --out tested"],
)
def safe() -> None:
    """Turn crash reports into scenarios, and test a policy with them."""


@click.group(
    cls=LazyGroup,
    table=_TRAIN,
    examples=[
        "roadmend train policy --out my-policy.safetensors",
        "roadmend train adreft --policy modular --out my-repair.safetensors",
    ],
)
def train() -> None:
    """Train a driving policy, a repair model or a rival's model.

    The first call sets torch up: its build for CUDA, of several gigabytes, unless a CPU build of the release in
    config/requirements/training.txt has been put into .venv with pip before. CUDA is used where it is there.
    """


@click.group(
    cls=LazyGroup,
    table=_SERA,
    examples=["roadmend sera analyse bags --out patterns.json", "roadmend sera cycle --generations 2 --out cycle"],
)
def sera() -> None:
    """Learn from the failures that were recorded."""


_COMMANDS: Table = {
    "run": ("roadmend.cli.run", "run", "Run one episode in the graph: SUMO, policy, repair and recorder."),
    "repair": ("roadmend.cli.repair", "repair", "Repair what your own stack drives: no simulator of ours."),
    "demo": ("roadmend.cli.demo", "demo", "See a collision repaired: the main job, end to end."),
    "sample": ("roadmend.cli.scenario", "sample", "Draw a scenario of a family."),
    "schema": ("roadmend.cli.scenario", "schema", "Print the JSON schema of a scenario file."),
    "networks": ("roadmend.cli.networks", "networks", "Make SUMO configurations that are foreign to roadmend."),
    "list": ("roadmend.cli.listing", "list_names", "Show policies, methods, techniques, families, backends or models."),
    "evaluate": ("roadmend.cli.evaluate", "evaluate", "Measure policies with repair methods in scenarios of yours."),
    "faults": ("roadmend.cli.faults", "faults", "Disturb the running graph on purpose, and judge what comes of it."),
    "search": ("roadmend.cli.search", "search", "Find scenarios in which a policy collides by its own fault."),
    "corpus": ("roadmend.cli.corpus", "corpus", "Gather, verify and show what policies are trained and measured on."),
    "safe": ("roadmend.cli.main", "safe", "Turn crash reports into scenarios, and test a policy with them."),
    "train": ("roadmend.cli.main", "train", "Train a driving policy, a repair model or a rival's model."),
    "sera": ("roadmend.cli.main", "sera", "Learn from the failures that were recorded."),
    "bag": ("roadmend.cli.main", "bag", "Look into bags, mend them, compare them."),
    "replay": ("roadmend.cli.replay", "replay", "Play a bag: publish what it holds, as it was recorded."),
    "completion": ("roadmend.cli.completion", "completion", "Print what makes a shell complete commands and options."),
}
_OF_CLONE = [  # commands of the script at the root, which a wheel does not have
    ("bench", "Make this repository's own figures again, in ratios."),
    ("test", "Check the project itself: import rules, lint, types, tests."),
    ("set-up", "Install what the commands need, or all of an extra, and do nothing else."),
]


@click.group(
    cls=LazyGroup,
    table=_COMMANDS,
    also=_OF_CLONE if is_clone() else [],
    examples=[
        "roadmend demo",
        "roadmend run --sumocfg my/town.sumocfg --repair adreft",
        "roadmend evaluate --family S3 --count 20 --repair adreft --repair rss --out measured",
    ],
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110},
)
@click.version_option(__version__, prog_name="roadmend")
def cli() -> None:
    """Repair a self-driving policy while it drives, and learn from what went wrong."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line, with what it was called with unless arguments are given; the exit code is the process's."""
    return run_group(cli, called_as(), sys.argv[1:] if arguments is None else arguments)


def run_group(group: click.Group, name: str, arguments: Sequence[str]) -> int:
    """Run a command of a group; every error is one line.

    Args:
        group: the commands.
        name: what the group is called on the command line.
        arguments: behind that name.

    Returns:
        0, 1 for a failure, 2 for bad input, 130 after an interrupt.
    """
    try:
        _refuse_another_sumo()
        code = group.main([*arguments], prog_name=name, complete_var=VARIABLE, standalone_mode=False)
    except InputError as error:
        return _complain(str(error), 2)
    except InterruptedWorkError as error:
        return _complain(str(error) + _way_on(error.resumes, name, arguments), 130)
    except RoadmendError as error:
        return _complain(str(error), 1)
    except ModuleNotFoundError as error:
        return _complain(str(extra_missing(error)), 2)
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(error.format_message())
        return 0
    except click.UsageError as error:
        asked = error.ctx.command_path if error.ctx is not None else name
        return _complain(f"{error.format_message()} (see '{asked} --help')", 2)
    except click.ClickException as error:
        return _complain(error.format_message(), 1)
    except OSError as error:
        if error.errno in _NO_PLACE and error.filename is not None:
            return _complain(f"{error.filename}: {error.strerror}; give another place", 2)
        if error.errno not in _NO_ROOM or error.filename is not None:
            raise
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # what is left of the output has no place to go
        return _complain(f"standard output: {error.strerror}; make room, or write elsewhere", 2)
    except (click.Abort, KeyboardInterrupt):
        return _complain("interrupted", 130)
    return int(code or 0)


def _refuse_another_sumo() -> None:
    """Raise InputError where PYTHONPATH, as SUMO's own set-up advises it, has a libsumo: it would take our one's place.

    Results would be another SUMO's under our version's name, and one that was built for another Python does not start.
    """
    for folder in filter(None, os.environ.get("PYTHONPATH", "").split(os.pathsep)):
        ours = sysconfig.get_path("platlib"), Path(__file__).parents[2]
        if (Path(folder) / "libsumo").is_dir() and not any(Path(folder).samefile(one) for one in ours):
            what = f"{folder} has a libsumo, which would take the place of the one that was installed with roadmend"
            raise InputError("PYTHONPATH", what, "leave that folder out, as in: env --unset=PYTHONPATH roadmend ...")


def _way_on(resumes: str | None, name: str, arguments: Sequence[str]) -> str:
    """How to go on with what an interrupted command has finished; nothing where it keeps nothing."""
    if resumes is None:
        return ""
    more = [word for word in resumes.split() if word not in arguments]
    return f"; what is finished is kept, go on with: {name} {shlex.join([*arguments, *more])}"


def _complain(text: str, code: int) -> int:
    print(f"roadmend: {' '.join(text.split())}", file=sys.stderr)
    return code
