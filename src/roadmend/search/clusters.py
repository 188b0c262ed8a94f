"""Leader clustering of behaviours: one pass, no number of clusters to choose."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray


class LeaderClusters:
    """A behaviour joins the nearest cluster within ``radius`` of its centre, or founds a new one."""

    def __init__(self, radius: float) -> None:
        """Start without clusters.

        Args:
            radius: root-mean-square difference of the features within which behaviours count as alike.
        """
        self._radius = radius
        self._centres: list[NDArray[np.float64]] = []
        self.counts: list[int] = []  # members of each cluster

    def __len__(self) -> int:
        return len(self._centres)

    def nearest(self, features: Sequence[float]) -> tuple[int, float]:
        """The nearest cluster and the distance to its centre; (-1, infinity) where there is none."""
        if not self._centres:
            return -1, float("inf")
        apart = np.sqrt(np.mean((np.array(self._centres) - np.asarray(features)) ** 2, axis=1))
        index = int(np.argmin(apart))
        return index, float(apart[index])

    def add(self, features: Sequence[float]) -> tuple[int, float]:
        """Count a behaviour in.

        Returns:
            Its cluster, and how new it was: distance to the nearest centre in radii, at most 1; 1 founds a cluster.
        """
        index, apart = self.nearest(features)
        if apart > self._radius:
            self._centres.append(np.array(features, dtype=np.float64))
            self.counts.append(1)
            return len(self._centres) - 1, 1.0
        self.counts[index] += 1
        self._centres[index] += (np.asarray(features) - self._centres[index]) / self.counts[index]
        return index, apart / self._radius
