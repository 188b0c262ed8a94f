"""How well a monitor finds the frames that the weak labels call critical (ADReFT section 4.2.1, table 3)."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from roadmend.measures.intervals import bootstrap, by_group

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Confusion:
    """Frames of one episode, counted by label and by what a monitor said."""

    hits: int  # labelled critical, and said to be
    false_alarms: int  # said to be, not labelled
    misses: int  # labelled, not said
    quiet: int  # neither

    @classmethod
    def of(cls, labels: Flags, alarms: Flags) -> Self:
        """Count.

        Args:
            labels: whether each frame is critical, shape (T,).
            alarms: whether the monitor says so, shape (T,).

        Raises:
            ValueError: the two differ in length.
        """
        if labels.shape != alarms.shape:
            raise ValueError(f"{len(labels)} labels for {len(alarms)} frames")
        return cls(
            int((labels & alarms).sum()),
            int((~labels & alarms).sum()),
            int((labels & ~alarms).sum()),
            int((~labels & ~alarms).sum()),
        )

    def dump(self) -> dict[str, int]:
        """As plain values."""
        return asdict(self)


def summarise_monitor(episodes: Sequence[Confusion], groups: Sequence[str]) -> dict[str, Any]:
    """Precision, recall and F1 in percent over all frames of all episodes pooled, with intervals.

    The intervals are of the bootstrap over groups, since frames of one episode, and episodes of one search, are anything
    but independent; None where there is one group.

    Args:
        episodes: counted.
        groups: of each episode: the search that found it.
    """
    table = np.array(
        [(episode.hits, episode.false_alarms, episode.misses) for episode in episodes], dtype=np.float64
    ).reshape(-1, 3)
    whole, sums = table.sum(axis=0, keepdims=True), by_group(table, groups)
    figures: dict[str, Any] = {"episodes": len(episodes), "frames": sum(_frames(episode) for episode in episodes)}
    figures["critical_frames"] = int(whole[0, 0] + whole[0, 2])
    intervals = {}
    for name, measure in (("precision", _precision), ("recall", _recall), ("f1", _f1)):
        value = float(measure((whole,))[0])
        figures[name] = value if np.isfinite(value) else None
        low, high = bootstrap((sums,), measure)
        intervals[name] = [low, high] if np.isfinite(low) and len(sums) > 1 else None
    return figures | {"intervals": intervals}


def separation_of(scores: Floats, critical: Flags) -> float | None:
    """Probability that what is critical has the larger score, ties counted half: the area under the ROC curve.

    Args:
        scores: shape (N,).
        critical: shape (N,).

    Returns:
        0 .. 1, or None where nothing or everything is critical.
    """
    bad, good = scores[critical], np.sort(scores[~critical])
    if not len(bad) or not len(good):
        return None
    below, not_above = (np.searchsorted(good, bad, side) for side in ("left", "right"))
    return float(np.mean(below + not_above) / (2 * len(good)))


def _frames(episode: Confusion) -> int:
    return episode.hits + episode.false_alarms + episode.misses + episode.quiet


def _precision(sums: tuple[Floats, ...]) -> Floats:
    return _percent(sums[0][:, 0], sums[0][:, 0] + sums[0][:, 1])


def _recall(sums: tuple[Floats, ...]) -> Floats:
    return _percent(sums[0][:, 0], sums[0][:, 0] + sums[0][:, 2])


def _f1(sums: tuple[Floats, ...]) -> Floats:
    hits, alarms, misses = sums[0].T
    return _percent(2.0 * hits, 2.0 * hits + alarms + misses)


def _percent(counts: Floats, of: Floats) -> Floats:
    return np.where(of > 0.0, 100.0 * counts / np.maximum(of, 1.0), np.nan)
