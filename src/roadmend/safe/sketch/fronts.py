"""Which end of an outline is the front: by the white triangle that NHTSA's older sketches have there."""

from itertools import pairwise

import cv2
import numpy as np

from roadmend.safe.sketch.crops import level_crop
from roadmend.safe.sketch.outlines import Outline, Paint
from roadmend.safe.sketch.picture import SketchPicture

_LENGTH = 200  # [pixels] of a levelled vehicle
_AREA = (0.004, 0.16)  # [of the vehicle] that the triangle covers
_TRIANGLE = 0.62  # [of the smallest triangle around it] that it fills
_AT_END = 0.12  # [of the length] that its middle is away from the vehicle's
_WHITE = 200  # [grey level]
_COLOURED = 90  # [levels] between the strongest and the weakest of red, green and blue
_SOLID = 0.6  # [of the vehicle] that its colour fills: the rest is number and triangle


def triangle_front(picture: SketchPicture, outline: Outline) -> int:
    """The end to which the triangle in a filled vehicle points: 1 along the axis, -1 against it, 0 where none is."""
    if outline.paint in {Paint.GREY, Paint.BLACK}:
        return 0
    height = max(16, round(_LENGTH * outline.width / outline.length))
    crop = level_crop(picture, outline, _LENGTH, height, -0.04)
    grey = np.asarray(cv2.cvtColor(crop, cv2.COLOR_RGB2GRAY))
    white = ((grey > _WHITE) & (np.ptp(crop, axis=2) < 60)).astype(np.uint8)
    if float((np.ptp(crop, axis=2) > _COLOURED).mean()) < _SOLID:  # an outline on paper, not a filled vehicle
        return 0
    contours, _ = cv2.findContours(white, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    found = []
    for contour in contours:
        area = float(cv2.contourArea(contour))
        if not _AREA[0] < area / (_LENGTH * height) < _AREA[1]:
            continue
        around, _ = cv2.minEnclosingTriangle(contour)
        left, top, width, tall = cv2.boundingRect(contour)
        touches = left <= 1 or top <= 1 or left + width >= _LENGTH - 1 or top + tall >= height - 1
        place = (left + width / 2) / _LENGTH - 0.5
        if not touches and area > _TRIANGLE * around and abs(place) > _AT_END:
            pointing = _pointing(contour.reshape(-1, 2), left, width)
            if pointing:
                found.append(pointing)
    return found[0] if len(found) == 1 else 0


def _pointing(points: np.ndarray, left: int, width: int) -> int:
    """The side of the apex: there the shape is narrow, at the other end it is wide."""
    heights = []
    for begin, end in pairwise(np.linspace(left, left + width, 5)):
        rows = points[(points[:, 0] >= begin - 0.5) & (points[:, 0] <= end + 0.5), 1]
        heights.append(float(np.ptp(rows)) if len(rows) else 0.0)
    first, last = heights[0], heights[-1]
    if first > 1.5 * last:
        return 1
    return -1 if last > 1.5 * first else 0
