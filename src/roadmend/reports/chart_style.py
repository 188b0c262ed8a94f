"""How charts look: colours by the role of a method, panels side by side, as little ink as possible."""

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

INK, MUTED, GRID = "#1f2328", "#7a828a", "#d9dde1"
WIDTH = 10.5  # [inch] of every chart


def new_figure(
    titles: Sequence[str], height: float, *, rows: int = 1, share_y: bool = False, legend: bool = True
) -> tuple[Figure, list[Axes]]:
    """A figure with one panel a title, side by side in rows; ``height`` in inches, ``legend`` makes room below."""
    figure = Figure(figsize=(WIDTH, height + (0.3 if legend else 0.0)), facecolor="white", layout="constrained")
    grid = figure.subplots(rows, len(titles) // rows, sharey="row" if share_y else False, squeeze=False)
    panels = [axes for row in grid for axes in row]
    for axes, title in zip(panels, titles, strict=True):
        axes.set_title(title, loc="left", fontsize=11, fontweight="bold", color=INK)
    return figure, panels


def despine(axes: Axes, grid: str = "") -> None:
    """Take away what says nothing; ``grid`` is x, y, both or nothing."""
    for name in ("top", "right", "left" if grid == "x" else "top"):
        axes.spines[name].set_visible(False)
    for spine in axes.spines.values():
        spine.set_color(GRID)
    axes.tick_params(colors=INK, labelsize=8.5)
    axes.xaxis.label.set_color(MUTED)
    axes.yaxis.label.set_color(MUTED)
    if grid:
        axes.grid(visible=True, axis=grid, color=GRID, lw=0.7, zorder=0)  # type: ignore[arg-type]
        axes.set_axisbelow(True)
