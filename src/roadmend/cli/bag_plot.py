"""``roadmend bag plot``: the one command on bags that needs what draws."""

import json
from collections.abc import Callable
from functools import partial
from pathlib import Path

import click

from roadmend.cli.command import ExampleCommand
from roadmend.cli.driver_options import DROVE
from roadmend.cli.foreign_bag_options import ForeignSceneOptions
from roadmend.cli.options import FUTURES, JSON, PATH, Number, options_of
from roadmend.core.errors import InputError
from roadmend.core.spell import Spell
from roadmend.recording.episode import BagEpisode, read_episode
from roadmend.recording.foreign_episode import read_foreign_episode
from roadmend.reports.bag_picture import draw_bag


@click.command(
    cls=ExampleCommand,
    examples=[
        "roadmend bag plot bags/my-run --out scene.png --at 12.5",
        "roadmend bag plot bags/my-run --out my-run.html --futures 20",
        "roadmend bag plot bags/theirs --ego /odom --objects /detections --out theirs.html",
    ],
)
@click.argument("bag", type=PATH)
@click.option(
    "--out",
    default=Path("scene.png"),
    show_default=True,
    type=PATH,
    help="PNG, SVG or PDF; or HTML, a page that shows the values of each tick.",
)
@click.option("--at", type=Number(0.0), help="Simulation time [s].  [default: the longest intervention]")
@click.option("--span", default=70.0, show_default=True, type=Number(10.0, 2000.0), help="Width of the scene [m].")
@FUTURES
@DROVE
@options_of(ForeignSceneOptions, "foreign")
@JSON
def plot(
    bag: Path,
    out: Path,
    at: float | None,
    span: float,
    futures: int,
    policy: str,
    foreign: ForeignSceneOptions,
    *,
    as_json: bool,
) -> None:
    """Draw the time line of a bag, with the scene at one moment.

    Interventions are drawn in the colour of what they were, with --futures: rescue, nuisance, or unclear. A page lists
    them as 'bag info' does. Of a bag that another stack recorded, or 'roadmend repair' beside it, name the topics.
    """
    read: Callable[[Path], BagEpisode] = _read_own
    if foreign.ego or foreign.objects:
        if futures:
            raise InputError("--futures", "another stack's drive cannot be driven again", "leave it out")
        read = partial(read_foreign_episode, ego=foreign.ego, objects=foreign.objects, vehicle=foreign.vehicle)
    moment = draw_bag(bag, out, at, span, _with_need(bag, futures, policy) if futures else (), read)
    click.echo(json.dumps({"file": str(out), "time": moment}) if as_json else f"{out}: {moment:.2f} s")


def _read_own(bag: Path) -> BagEpisode:
    try:
        return read_episode(bag)
    except InputError as error:
        if not Path(bag).exists():
            raise
        mend = f"{error.mend}, or name the topics of another stack's bag with --ego and --objects"
        raise InputError(error.where, error.what, mend) from None


def _with_need(bag: Path, futures: int, policy: str) -> tuple[Spell, ...]:
    from roadmend.cli.bag_need import needs_of  # noqa: PLC0415 - SUMO and the policies; most calls drive nothing

    return needs_of(bag, futures, policy)
