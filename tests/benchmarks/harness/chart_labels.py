"""What the charts of the benchmarks are labelled with: methods, groups, legends, names beside points."""

from collections.abc import Mapping, Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke

from harness.benchmark_tables import title_of
from roadmend.reports.chart_style import INK, MUTED

Content = Mapping[str, Any]
GROUP_COLOUR = {  # hues of Okabe and Ito, see scene_style
    "adreft": "#d55e00",
    "rival": "#0072b2",
    "variant": "#e69f00",
    "ablation": "#56b4e9",
    "bound": "#009e73",
    "control": "#cc79a7",
    "reference": "#7a828a",
}
GROUP_TITLE = {
    "adreft": "ADReFT",
    "variant": "variant",
    "ablation": "ablation",
    "rival": "rival",
    "bound": "hindsight bound",
    "control": "control",
    "reference": "no repair",
}
_HALO = (withStroke(linewidth=2.5, foreground="white"),)
_STEPS = (0.6, -0.6, 1.2, -1.2, 1.8, -1.8, 2.4, -2.4, 3.0, -3.0, 3.6, -3.6)  # heights of a line up or down


def colour_of(content: Content, method: str) -> str:
    """Colour of a method's group."""
    return GROUP_COLOUR[content["titles"].get(method, {}).get("group", "reference")]


def name_methods(axes: Axes, content: Content, methods: Sequence[str]) -> None:
    """Methods from the bottom up on the y axis."""
    axes.set_yticks(range(len(methods)), [title_of(content, method) for method in methods])
    for label, method in zip(axes.get_yticklabels(), methods, strict=False):  # shared axes have none
        label.set_fontweight("bold" if method == "adreft" else "normal")
    axes.set_ylim(-0.6, len(methods) - 0.4)
    axes.tick_params(axis="y", length=0)


def group_handles(content: Content, methods: Sequence[str]) -> list[Any]:
    """For the legend: the groups of some methods."""
    groups = {content["titles"][method]["group"] for method in methods if method in content["titles"]}
    return [
        Line2D([], [], marker="o", ls="", color=GROUP_COLOUR[group], label=title)
        for group, title in GROUP_TITLE.items()
        if group in groups
    ]


def add_legend(figure: Figure, handles: Sequence[Any]) -> None:
    """A legend below all panels."""
    figure.legend(
        handles=handles,
        loc="outside lower left",
        ncols=len(handles),
        frameon=False,
        fontsize=8.5,
        labelcolor=INK,
        handletextpad=0.4,
        columnspacing=1.4,
    )


def label_points(axes: Axes, points: Sequence[tuple[float, float, str, str]]) -> None:
    """A name beside each point (x, y, name, colour), where it runs into no other name, no point and no edge."""
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    box = axes.get_position()
    figure = axes.get_figure(root=True)
    assert figure is not None
    size = figure.get_size_inches()
    across, up = (right - left) / (box.width * size[0]), (high - low) / (box.height * size[1])  # units an inch
    height, gap, dot = 0.15 * up, 0.09 * across, 0.05
    taken = [(x - dot * across, x + dot * across, y - dot * up, y + dot * up) for x, y, _, _ in points]
    for x, y, name, colour in sorted(points, key=lambda point: -point[1]):
        width = 0.066 * len(name) * across
        places = [(begin, y + step * height) for step in _STEPS for begin in (x + gap, x - gap - width)]
        boxes = [(begin, begin + width, middle - 0.5 * height, middle + 0.5 * height) for begin, middle in places]
        inside = [each for each in boxes if each[0] >= left and each[1] <= right and each[2] >= low and each[3] <= high]
        chosen = next((each for each in inside if not any(_overlap(each, other) for other in taken)), boxes[0])
        taken.append(chosen)
        is_right, middle = chosen[0] > x, 0.5 * (chosen[2] + chosen[3])
        axes.annotate(
            name,
            (x, y),
            (chosen[0] if is_right else chosen[1], middle),
            ha="left" if is_right else "right",
            va="center",
            fontsize=8,
            color=colour,
            path_effects=_HALO,
            arrowprops={"arrowstyle": "-", "color": MUTED, "lw": 0.6} if abs(middle - y) > 1.2 * height else None,
        )


def _overlap(first: tuple[float, ...], second: tuple[float, ...]) -> bool:
    return first[0] < second[1] and second[0] < first[1] and first[2] < second[3] and second[2] < first[3]
