"""Where north is on a sketch: a compass disc with an arrow in it, or an N beside an arrow."""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import cv2
import numpy as np
from numpy.typing import NDArray

from roadmend.safe.claims import Box
from roadmend.safe.sketch.arrows import DrawnArrow, arrow_of, dark_mask
from roadmend.safe.sketch.picture import SketchPicture
from roadmend.safe.sketch.words import SketchWord

_LETTER = re.compile(r"\W*(?:n|north)\W*", re.IGNORECASE)
_NEAR = 2.6  # [heights of the letter] between it and its arrow
_RADIUS = (0.006, 0.1)  # [of the diagonal] of a compass disc
_ROUND = 0.9  # [of the circle around it] that a disc fills
_BLACK = (0.2, 0.85)  # [of a disc] that is dark
_SIDE = 48  # [pixels] of the pattern
_STEP = 5  # [deg]
_MATCH = 0.55  # [of 1] correlation with the pattern
_SPECK = 8  # [pixels] smaller pieces are dirt
_PIECES = 10  # nearest to the letter, of which two may make an arrow
_CERTAIN = 0.95
_BESIDE = 0.9


@dataclass(frozen=True, slots=True)
class NorthMark:
    """Where north is.

    Attributes:
        heading: of north, from -180 to 180, counter-clockwise from the right of the picture [deg].
        box: around the sign that says so [pixels].
        confidence: from 0 to 1.
    """

    heading: float
    box: Box
    confidence: float


def find_north(picture: SketchPicture, words: Sequence[SketchWord], arrows: Sequence[DrawnArrow]) -> NorthMark | None:
    """The mark of north; None where there is none, or several that disagree."""
    marks = _discs(picture) or _letters(picture, words, arrows)
    if not marks:
        return None
    best = max(marks, key=lambda mark: mark.confidence)
    if any(abs(math.remainder(mark.heading - best.heading, 360.0)) > 30 for mark in marks):
        return None
    return best


def _pattern(half_head: float, base: float, tip: float) -> NDArray[np.float32]:
    """A block arrow that points to the right, 1, in a disc of -1; 0 around it."""
    rows, columns = np.mgrid[0:_SIDE, 0:_SIDE]
    x = (columns - (_SIDE - 1) / 2) / (_SIDE / 2)
    y = (rows - (_SIDE - 1) / 2) / (_SIDE / 2)
    head = (x >= base) & (np.abs(y) <= half_head * (tip - x) / (tip - base))
    shaft = (x < base) & (np.abs(y) <= 0.28)
    values = np.where(head | shaft, 1.0, -1.0)
    return np.where(np.hypot(x, y) <= 0.92, values, 0.0).astype(np.float32)


_PATTERNS = (_pattern(1.0, 0.0, 1.0), _pattern(0.7, 0.1, 0.8))


def _discs(picture: SketchPicture) -> list[NorthMark]:
    drawn = ((picture.grey < 200) & (picture.coloured == 0)).astype(np.uint8)
    contours, _ = cv2.findContours(drawn, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    marks = []
    for contour in contours:
        (x, y), radius = cv2.minEnclosingCircle(contour)
        if not max(6.0, _RADIUS[0] * picture.diagonal) < radius < _RADIUS[1] * picture.diagonal:
            continue
        if cv2.contourArea(contour) < _ROUND * math.pi * radius**2:
            continue
        mark = _arrow_in(picture, float(x), float(y), float(radius))
        if mark is not None:
            marks.append(mark)
    return marks


def _arrow_in(picture: SketchPicture, x: float, y: float, radius: float) -> NorthMark | None:
    size = max(2, round(2 * radius))
    patch = cv2.getRectSubPix(picture.grey, (size, size), (x, y))
    patch = np.asarray(cv2.resize(patch, (_SIDE, _SIDE), interpolation=cv2.INTER_AREA), np.float32)
    inside = _PATTERNS[0] != 0
    if not _BLACK[0] < float((patch[inside] < 100).mean()) < _BLACK[1]:
        return None
    best, heading = 0.0, 0
    for pattern in _PATTERNS:
        for angle in range(0, 360, _STEP):
            turn = cv2.getRotationMatrix2D(((_SIDE - 1) / 2, (_SIDE - 1) / 2), angle, 1.0)
            turned = np.asarray(cv2.warpAffine(pattern, turn, (_SIDE, _SIDE)))
            match = abs(float(np.corrcoef(turned[inside], patch[inside])[0, 1]))  # black on grey, or white on black
            if match > best:
                best, heading = match, angle
    if best < _MATCH:
        return None
    box = Box(max(0.0, x - radius), max(0.0, y - radius), x + radius, y + radius)
    return NorthMark(math.remainder(heading, 360.0), box, _CERTAIN)


def _letters(picture: SketchPicture, words: Sequence[SketchWord], arrows: Sequence[DrawnArrow]) -> list[NorthMark]:
    marks = []
    for word in words:
        if not _LETTER.fullmatch(word.text.strip()):
            continue
        size = min(word.height, word.box.right - word.box.left)
        near = [
            arrow
            for arrow in arrows
            if _distance(arrow, word) < _NEAR * size and arrow.length < 9 * size and _aside(arrow, word) < 0.6 * size
        ]
        arrow = min(near, key=lambda arrow: _distance(arrow, word)) if near else _pieced(picture, word)
        if arrow is not None:
            ends = np.array([arrow.tail, arrow.tip])
            left, top = np.minimum(ends.min(axis=0), (word.box.left, word.box.top))
            right, bottom = np.maximum(ends.max(axis=0), (word.box.right, word.box.bottom))
            box = Box(float(left), float(top), float(right), float(bottom))
            marks.append(NorthMark(arrow.heading, box, _BESIDE * word.confidence**0.25))
    return marks


def _distance(arrow: DrawnArrow, word: SketchWord) -> float:
    """Between the arrow and the word's middle [pixels]."""
    begin, end, middle = (np.array(point) for point in (arrow.tail, arrow.tip, word.centre))
    share = float(np.clip(np.dot(middle - begin, end - begin) / max(1e-9, arrow.length**2), 0.0, 1.0))
    return float(np.linalg.norm(begin + share * (end - begin) - middle))


def _aside(arrow: DrawnArrow, word: SketchWord) -> float:
    """Between the line that the arrow lies on and the word's middle [pixels]."""
    across, down = arrow.tip[0] - arrow.tail[0], arrow.tip[1] - arrow.tail[1]
    x, y = word.centre[0] - arrow.tail[0], word.centre[1] - arrow.tail[1]
    return abs(x * down - y * across) / max(1e-9, arrow.length)


def _pieced(picture: SketchPicture, word: SketchWord) -> DrawnArrow | None:
    """An arrow whose head and shaft do not touch, in line with the letter."""
    x, y = word.centre
    size = max(word.height, word.box.right - word.box.left)
    left, top = max(0, int(x - _NEAR * size)), max(0, int(y - _NEAR * size))
    patch = dark_mask(picture)[top : int(y + _NEAR * size) + 1, left : int(x + _NEAR * size) + 1]
    count, labels = cv2.connectedComponents(np.ascontiguousarray(patch), connectivity=8)
    pieces = []
    for label in range(1, count):
        rows, columns = np.nonzero(labels == label)
        if len(rows) > _SPECK and max(np.ptp(rows), np.ptp(columns)) < 2 * size:
            pieces.append(np.column_stack([columns + left, rows + top]).astype(float))
    pieces.sort(key=lambda piece: float(np.hypot(*(piece.mean(axis=0) - (x, y)))))
    found = []
    for first, second in combinations(pieces[:_PIECES], 2):
        arrow = arrow_of(np.concatenate([first, second]))
        if arrow is not None and 0.3 * size < arrow.length < 4 * size and _aside(arrow, word) < 0.5 * size:
            found.append(arrow)
    return min(found, key=lambda arrow: _distance(arrow, word)) if found else None
