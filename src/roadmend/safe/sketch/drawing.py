"""What was read from a sketch, drawn over it."""

import math

import cv2
import numpy as np

from roadmend.core.appearance import VEHICLE_COLOURS
from roadmend.safe.claims import Box
from roadmend.safe.sketch.conditions import conditions
from roadmend.safe.sketch.picture import Pixels
from roadmend.safe.sketch.reading import SketchReading

Colour = tuple[int, int, int]  # RGB

_UNKNOWN: Colour = (120, 120, 120)
_LIMIT: Colour = (0, 130, 0)
_CONDITION: Colour = (120, 60, 200)
_NORTH: Colour = (0, 130, 150)
_WASHED = 0.55  # of the sketch's own strength that is left under what is drawn over it
_FONT = cv2.FONT_HERSHEY_SIMPLEX


def drawn_over(reading: SketchReading) -> bytes:
    """The sketch, paler, with what was read of it, as a PNG file.

    Vehicles have their number and, thick and with an arrow, the pose from which they come; limits, light and weather
    have a box with their value; north has its arrow.
    """
    canvas = np.asarray(255 - (255 - reading.picture.colours.astype(float)) * _WASHED).astype(np.uint8)
    line = max(1, round(reading.picture.diagonal / 900))
    for limit in reading.limits:
        _boxed(canvas, limit.box, f"{limit.mph} mph", _LIMIT, line)
    named: dict[Box, list[str]] = {}
    for condition in conditions(reading.words):
        named.setdefault(condition.box, []).append(condition.value.value)
    for box, values in named.items():
        _boxed(canvas, box, ", ".join(values), _CONDITION, line, is_below=True)
    first = {id(approach.pose) for approach in reading.approaches.values()}
    for pose in reading.poses:
        colour = _UNKNOWN if pose.number is None else _vehicle(pose.number)
        corners = pose.outline.corners().round().astype(np.int32)
        cv2.polylines(canvas, [corners], True, colour, 2 * line if id(pose) in first else line, cv2.LINE_AA)
        if pose.number is not None:
            _label(canvas, f"V{pose.number}", (pose.outline.box().right + 2, pose.outline.box().top), colour, line)
    for number, approach in reading.approaches.items():
        outline = approach.pose.outline
        _arrow(canvas, outline.centre, approach.heading, 1.1 * outline.length, _vehicle(number), 2 * line)
    if reading.north is not None:
        box = reading.north.box
        middle = (box.left + box.right) / 2, (box.top + box.bottom) / 2
        size = max(box.right - box.left, box.bottom - box.top)
        _boxed(canvas, box, "north", _NORTH, line)
        _arrow(canvas, middle, reading.north.heading, 0.7 * size, _NORTH, 2 * line)
    done, data = cv2.imencode(".png", canvas[..., ::-1])
    if not done:
        raise RuntimeError("the picture could not be encoded")
    return bytes(data)


def _boxed(canvas: Pixels, box: Box, text: str, colour: Colour, line: int, *, is_below: bool = False) -> None:
    cv2.rectangle(canvas, _corner(box.left, box.top), _corner(box.right, box.bottom), colour, line, cv2.LINE_AA)
    _label(canvas, text, (box.left, box.bottom + 16 * line if is_below else box.top), colour, line)


def _label(canvas: Pixels, text: str, at: tuple[float, float], colour: Colour, line: int) -> None:
    size = 0.42 * line + 0.12
    (width, height), _ = cv2.getTextSize(text, _FONT, size, line)
    left = min(max(0, int(at[0])), max(0, canvas.shape[1] - width - 1))
    bottom = max(height + 2, int(at[1]) - 2)
    cv2.rectangle(canvas, (left - 1, bottom - height - 2), (left + width + 1, bottom + 2), (255, 255, 255), cv2.FILLED)
    cv2.putText(canvas, text, (left, bottom), _FONT, size, colour, line, cv2.LINE_AA)


def _arrow(
    canvas: Pixels, begin: tuple[float, float], heading: float, length: float, colour: Colour, line: int
) -> None:
    way = math.radians(heading)
    end = begin[0] + length * math.cos(way), begin[1] - length * math.sin(way)
    cv2.arrowedLine(canvas, _corner(*begin), _corner(*end), colour, line, cv2.LINE_AA, tipLength=0.25)


def _vehicle(number: int) -> Colour:
    colour = VEHICLE_COLOURS[(number - 1) % len(VEHICLE_COLOURS)]
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)


def _corner(x: float, y: float) -> tuple[int, int]:
    return round(x), round(y)
