"""The arrows of a sketch: a thin shaft that ends in a wide head."""

import math
from dataclasses import dataclass
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from roadmend.safe.sketch.picture import Mask, SketchPicture

_DARK = 130  # [grey level]
_LENGTH = (0.014, 0.45)  # [of the diagonal]
_HEAD = 1.9  # [times the typical width] that the head is wide at least
_HEAD_WITHIN = 0.45  # [of the length] from the tip, the head's widest place
_THIN = 0.45  # [of the length] that an arrow is wide at most
_BINS = 24
_GAPS = 3  # of the bins, between head and shaft
_TIP = 0.75  # [of the head's width] that the last bin is wide at most


@dataclass(frozen=True, slots=True)
class DrawnArrow:
    """An arrow.

    Attributes:
        tail, tip: x to the right, y down [pixels].
    """

    tail: tuple[float, float]
    tip: tuple[float, float]

    @property
    def heading(self) -> float:
        """Where it points, from -180 to 180, counter-clockwise from the right [deg]."""
        return math.degrees(math.atan2(self.tail[1] - self.tip[1], self.tip[0] - self.tail[0]))

    @property
    def length(self) -> float:
        """In pixels."""
        return math.dist(self.tail, self.tip)


def dark_mask(picture: SketchPicture) -> Mask:
    """What is black or nearly so."""
    return np.asarray(((picture.grey < _DARK) & (picture.coloured == 0)).astype(np.uint8) * np.uint8(255))


def find_arrows(picture: SketchPicture) -> tuple[DrawnArrow, ...]:
    """All arrows in black that touch nothing else."""
    count, labels, stats, _ = cv2.connectedComponentsWithStats(dark_mask(picture), connectivity=8)
    found = []
    for label in range(1, count):
        left, top, width, height, _ = (int(value) for value in stats[label])
        if not _LENGTH[0] * picture.diagonal < math.hypot(width, height) < _LENGTH[1] * picture.diagonal:
            continue
        rows, columns = np.nonzero(labels[top : top + height, left : left + width] == label)
        arrow = arrow_of(np.column_stack([columns + left, rows + top]).astype(float))
        if arrow is not None:
            found.append(arrow)
    return tuple(found)


def arrow_of(points: NDArray[np.float64]) -> DrawnArrow | None:
    """The arrow that some drawn pixels make, of shape (n, 2); None where they make none."""
    if len(points) < 12:
        return None
    middle = points.mean(axis=0)
    _, _, axes = np.linalg.svd(points - middle, full_matrices=False)
    along, aside = (points - middle) @ axes[0], (points - middle) @ axes[1]
    low, high = float(along.min()), float(along.max())
    length = high - low
    if length < 8 or float(np.ptp(aside)) > _THIN * length:
        return None
    edges = np.linspace(low, high, _BINS + 1)
    widths = []
    for begin, end in pairwise(edges):
        inside = aside[(along >= begin) & (along <= end)]
        widths.append(float(np.ptp(inside)) + 1.0 if len(inside) else 0.0)
    shaft, widest = float(np.median([width for width in widths if width > 0])), int(np.argmax(widths))
    if widths.count(0.0) > _GAPS:
        return None
    place = (widest + 0.5) / _BINS
    if widths[widest] < _HEAD * shaft or min(place, 1.0 - place) > _HEAD_WITHIN or shaft > 0.25 * length:
        return None
    tip, tail = (high, low) if place > 0.5 else (low, high)
    # The head is narrow at its tip, unlike the bar of a T or a letter beside a line, and what is behind it is shaft.
    behind = widths[: _BINS // 2] if place > 0.5 else widths[_BINS // 2 :]
    if max(behind) > 0.75 * widths[widest] or (widths[-1] if place > 0.5 else widths[0]) > _TIP * widths[widest]:
        return None
    return DrawnArrow(_point(middle + tail * axes[0]), _point(middle + tip * axes[0]))


def _point(values: NDArray[np.float64]) -> tuple[float, float]:
    return float(values[0]), float(values[1])
