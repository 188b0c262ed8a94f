"""Where vehicles are drawn on a sketch: filled rectangles, bodies in grey, outlines in colour or in black."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

import cv2
import numpy as np
from numpy.typing import NDArray

from roadmend.safe.claims import Box
from roadmend.safe.sketch.picture import Mask, SketchPicture
from roadmend.safe.sketch.words import SketchWord

_LENGTH = (0.012, 0.34)  # [of the diagonal] of a vehicle
_ASPECT = (1.45, 5.5)  # length by width of a vehicle, a truck with its trailer among them
_FILLED = 0.72  # [of its rectangle] that a vehicle fills
_ALIKE = (0.6, 1.9)  # length by that of a typical vehicle of the sketch, for what has no colour
_BODY = 228  # [grey level] darker may be a body
_TOGETHER = 0.6  # [of a rectangle] that two vehicles in it fill, the pieces of one do not
_TINT = 0.12  # [of a body] that lines of a colour cover
_SLENDER = 3.4  # length by width, of what has no colour
_LETTERHEAD = ("nhtsa", "case number", "www.")


class Paint(StrEnum):
    """What a vehicle is drawn in."""

    RED = "red"
    ORANGE = "orange"
    GREEN = "green"
    BLUE = "blue"
    GREY = "grey"
    BLACK = "black"


_HUES = {  # [2 deg] from, to; red goes round
    Paint.RED: ((0, 11), (168, 180)),
    Paint.ORANGE: ((11, 24),),
    Paint.GREEN: ((36, 86),),
    Paint.BLUE: ((86, 136),),
}


@dataclass(frozen=True, slots=True)
class Outline:
    """A rectangle around a vehicle.

    Attributes:
        centre: x to the right, y down [pixels].
        length, width: [pixels].
        axis: of its length, from 0 to 180, counter-clockwise from the right [deg].
        paint: what it is drawn in.
    """

    centre: tuple[float, float]
    length: float
    width: float
    axis: float
    paint: Paint

    def corners(self) -> NDArray[np.float64]:
        """Of shape (4, 2) [pixels]: front left, front right, rear right, rear left, if the axis led to the front."""
        angle = math.radians(self.axis)
        along = np.array([math.cos(angle), -math.sin(angle)]) * self.length / 2
        left = np.array([-math.sin(angle), -math.cos(angle)]) * self.width / 2
        middle = np.array(self.centre)
        return np.stack([middle + along + left, middle + along - left, middle - along - left, middle - along + left])

    def box(self) -> Box:
        """Upright around it [pixels]."""
        corners = self.corners()
        (left, top), (right, bottom) = corners.min(axis=0), corners.max(axis=0)
        return Box(float(left), float(top), float(right), float(bottom))

    def holds(self, point: tuple[float, float], margin: float = 1.0) -> bool:
        """Whether a point lies in it, made larger by a factor."""
        angle = math.radians(self.axis)
        across, down = point[0] - self.centre[0], point[1] - self.centre[1]
        along = across * math.cos(angle) - down * math.sin(angle)
        aside = across * math.sin(angle) + down * math.cos(angle)
        return abs(along) <= margin * self.length / 2 and abs(aside) <= margin * self.width / 2


def find_outlines(picture: SketchPicture, words: Sequence[SketchWord]) -> tuple[Outline, ...]:
    """All that look like vehicles, largest first."""
    writing = _writing_mask(picture, words)
    reach = max(3, round(picture.diagonal / 350) | 1)
    found: list[Outline] = []
    for paint in (Paint.RED, Paint.BLUE, Paint.GREEN, Paint.ORANGE):
        mask = cv2.bitwise_and(_hue_mask(picture, _HUES[paint]), cv2.bitwise_not(writing))
        found.extend(_new(_joined(_mask(mask), (1, 3, 5), reach, picture, paint), found))
    body = cv2.morphologyEx((picture.grey < _BODY).astype(np.uint8), cv2.MORPH_OPEN, np.ones((4, 4), np.uint8))
    body = cv2.bitwise_and(np.asarray(body * np.uint8(255)), cv2.bitwise_not(writing))
    found.extend(_alike(_new(_joined(_mask(body), (1, 3, 5), reach, picture, Paint.GREY), found), found))
    black = cv2.bitwise_and(picture.thin_ink, cv2.bitwise_not(writing))
    found.extend(_alike(_new(_joined(_mask(black), (1, 2), 3, picture, Paint.BLACK), found), found))
    sentences = [word.centre for word in words if sum(letter.isalnum() for letter in word.text) > 3]
    vehicles = [outline for outline in found if not any(outline.holds(centre) for centre in sentences)]
    return tuple(sorted(vehicles, key=lambda outline: -outline.length))


def _alike(outlines: Iterable[Outline], known: Sequence[Outline]) -> list[Outline]:
    """Those as long as the vehicles that are known: signs and arrow heads are drawn in black and grey too."""
    if not known:
        return list(outlines)
    typical = float(np.median([outline.length for outline in known]))
    return [
        outline
        for outline in outlines
        if _ALIKE[0] < outline.length / typical < _ALIKE[1] and outline.length < _SLENDER * outline.width
    ]


def _joined(mask: Mask, times: Sequence[int], reach: int, picture: SketchPicture, paint: Paint) -> list[Outline]:
    """The vehicles of a mask whose pieces are joined over narrow gaps, and over wider ones.

    A body with white windows comes in pieces, and only the widest joins them; two vehicles close to each other are
    joined by it too, and come as two that fill most of what they are in together.
    """
    found: list[Outline] = []
    for factor in times:
        for wide in _rectangles(_closed(mask, factor * reach | 1), picture, paint):
            inside = [outline for outline in found if wide.holds(outline.centre)]
            pieces = sum(outline.length * outline.width for outline in inside)
            if len(inside) >= 2 and pieces > _TOGETHER * wide.length * wide.width:
                continue
            found = [outline for outline in found if outline not in inside]
            found.append(_painted(wide, picture) if paint is Paint.GREY else wide)
    return found


def _painted(outline: Outline, picture: SketchPicture) -> Outline:
    """A body in grey whose lines have a colour is of that colour."""
    inside = np.zeros(picture.grey.shape, np.uint8)
    cv2.fillPoly(inside, [outline.corners().round().astype(np.int32)], 255)
    whole = int(cv2.countNonZero(inside))
    for paint, hues in _HUES.items():
        coloured = int(cv2.countNonZero(cv2.bitwise_and(_hue_mask(picture, hues), inside)))
        if coloured > _TINT * whole:
            return replace(outline, paint=paint)
    return outline


def _writing_mask(picture: SketchPicture, words: Sequence[SketchWord]) -> Mask:
    """What is no vehicle because it is writing: words of more than three letters, and the letterhead."""
    mask = np.zeros(picture.grey.shape, np.uint8)
    for word in words:
        plain = word.text.strip().lower()
        if sum(letter.isalnum() for letter in plain) > 3 or "★" in plain:
            _blank(mask, word.box, 2)
        if plain.startswith(_LETTERHEAD):
            _blank(mask, word.box, 0.6 * word.height)
    return mask


def _blank(mask: Mask, box: Box, margin: float) -> None:
    left, top = max(0, int(box.left - margin)), max(0, int(box.top - margin))
    mask[top : int(box.bottom + margin) + 1, left : int(box.right + margin) + 1] = 255


def _hue_mask(picture: SketchPicture, ranges: Iterable[tuple[int, int]]) -> Mask:
    hue = picture.hsv[..., 0]
    inside = np.zeros(hue.shape, np.bool_)
    for low, high in ranges:
        inside |= (hue >= low) & (hue < high)
    return _mask(cv2.bitwise_and(picture.coloured, inside.astype(np.uint8) * np.uint8(255)))


def _closed(mask: Mask, reach: int) -> Mask:
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (reach, reach))
    return _mask(cv2.morphologyEx(mask, cv2.MORPH_CLOSE, kernel))


def _mask(values: object) -> Mask:
    return np.ascontiguousarray(values, dtype=np.uint8)


def _rectangles(mask: Mask, picture: SketchPicture, paint: Paint) -> list[Outline]:
    contours, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    found = []
    for contour in contours:
        (x, y), (first, second), turn = cv2.minAreaRect(contour)
        length, width = max(first, second), min(first, second)
        if not _LENGTH[0] * picture.diagonal < length < _LENGTH[1] * picture.diagonal or width < 5:
            continue
        if not _ASPECT[0] < length / width < _ASPECT[1] or cv2.contourArea(contour) < _FILLED * length * width:
            continue
        axis = -turn if first >= second else -(turn + 90)
        found.append(Outline((float(x), float(y)), float(length), float(width), float(axis % 180), paint))
    return found


def _new(outlines: Iterable[Outline], known: Sequence[Outline]) -> list[Outline]:
    return [
        outline
        for outline in outlines
        if not any(other.holds(outline.centre) or outline.holds(other.centre) for other in known)
    ]
