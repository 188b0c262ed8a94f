"""An evaluation for a browser: the table of the measures, what its columns mean, and every episode."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from roadmend.core.whole_file import write_texts
from roadmend.reports.page import render
from roadmend.reports.result_files import origin

_NAME = "evaluation.html"
_COLUMNS = {
    "policy": "policy",
    "method": "repair",
    "scenario": "scenario",
    "outcome": "outcome",
    "text": "what happened",
}
_FIGURES = {"duration": "after [s]", "min_distance": "nearest [m]", "dose": "dose [s]"}
_DASH = "\N{EN DASH}"


def write_page(
    folder: Path,
    title: str,
    rows: Sequence[Sequence[str]],
    meanings: Sequence[str],
    episodes: Sequence[Mapping[str, Any]],
    faults: Sequence[str],
    made: Mapping[str, Any],
) -> Path:
    """Write evaluation.html, which needs nothing but itself; returns its path.

    Args:
        folder: where.
        title: heading of the page.
        rows: the table of the measures, its heading first.
        meanings: of its columns.
        episodes: figures of each.
        faults: why some could not be driven.
        made: by what, see ``result_files.provenance``.

    Raises:
        InputError: the folder cannot be written.
    """
    listed = [[*_COLUMNS.values(), *_FIGURES.values()]]
    listed += [[str(each[name]) for name in _COLUMNS] + [_number(each[name]) for name in _FIGURES] for each in episodes]
    text = render(
        "evaluation.html",
        title=title,
        rows=rows,
        meanings=meanings,
        episodes=listed,
        faults=faults,
        made=origin(made),
    )
    write_texts(folder, {_NAME: text})
    return folder / _NAME


def _number(value: float | None) -> str:
    return _DASH if value is None else f"{value:.2f}"
