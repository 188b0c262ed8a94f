"""The four measures over many episodes: means with 95 % intervals."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roadmend.measures.driving import DrivingMeasures
from roadmend.measures.intervals import bootstrap, wilson

Floats = NDArray[np.float64]

MEASURES = ("driving_score", "success_rate", "efficiency", "comfortness")
_HEAD = (
    "set",
    "episodes",
    "Driving Score",
    "95 %",
    "Success Rate",
    "95 %",
    "Efficiency",
    "95 %",
    "Comfortness",
    "95 %",
)
_DASH = "-"


def summarise(measures: Sequence[DrivingMeasures]) -> dict[str, Any]:
    """Means and intervals as plain values, None where nothing can be told.

    Driving Score and Comfortness are of 100, Success Rate and Efficiency in percent. The interval of the Success Rate
    is Wilson's, the others are the bootstrap's over episodes, of which it takes two to tell anything.
    """
    count = len(measures)
    successes = sum(one.success for one in measures)
    low, high = wilson(successes, count) if count else (None, None)
    return {
        "episodes": count,
        "driving_score": _mean([one.driving_score for one in measures]),
        "success_rate": {
            "mean": 100.0 * successes / count if count else None,
            "interval": None if low is None or high is None else [100.0 * low, 100.0 * high],
        },
        "efficiency": _mean([one.efficiency for one in measures]),
        "comfortness": _mean([one.comfortness for one in measures]),
    }


def summary_rows(summaries: Mapping[str, Mapping[str, Any]]) -> list[list[str]]:
    """A table of summaries by their names, the heading first."""
    rows = [[*_HEAD]]
    for name, summary in summaries.items():
        cells = [name, str(summary["episodes"])]
        for measure in MEASURES:
            mean, interval = summary[measure]["mean"], summary[measure]["interval"]
            cells.append(_DASH if mean is None else f"{mean:.1f}")
            cells.append(_DASH if interval is None else f"{interval[0]:.1f} .. {interval[1]:.1f}")
        rows.append(cells)
    return rows


def _mean(values: Sequence[float | None]) -> dict[str, Any]:
    known = [value for value in values if value is not None]
    if not known:
        return {"mean": None, "interval": None}
    mean = float(np.mean(known))
    if len(known) < 2:
        return {"mean": mean, "interval": None}
    table = np.column_stack([known, np.ones(len(known))])
    interval = bootstrap((table,), lambda sums: np.asarray(sums[0][:, 0] / sums[0][:, 1], dtype=np.float64))
    return {"mean": mean, "interval": [*interval]}
