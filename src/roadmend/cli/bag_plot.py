"""``roadmend bag plot``: a recorded episode drawn, as a picture or as a page."""

from pathlib import Path

import click

from roadmend.reports.bag_picture import draw_bag


@click.command()
@click.argument("bag", type=click.Path(path_type=Path))
@click.option(
    "--out",
    default=Path("scene.png"),
    show_default=True,
    type=click.Path(path_type=Path),
    help="PNG, SVG or PDF; or HTML, a page that shows the values of each tick.",
)
@click.option("--at", type=click.FloatRange(0.0), help="Simulation time [s].  [default: the longest intervention]")
@click.option(
    "--span", default=70.0, show_default=True, type=click.FloatRange(10.0, 2000.0), help="Width of the scene [m]."
)
def plot(bag: Path, out: Path, at: float | None, span: float) -> None:
    """Draw the time line of a bag, with the scene at one moment."""
    moment = draw_bag(bag, out, at, span)
    click.echo(f"{out}: {moment:.2f} s")
