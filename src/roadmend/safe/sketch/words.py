"""The words of a sketch, by an OCR library whose models come in its wheel: nothing is fetched."""

import math
import re
import threading
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import rapidocr
from rapidocr import RapidOCR

from roadmend.core.errors import InputError
from roadmend.safe.claims import Box
from roadmend.safe.sketch.picture import Pixels, SketchPicture

_TRUSTED = 0.5  # [of 1] a word that the library is less sure of is none
_SHORT_SIDE = 1100  # [pixels] a smaller sketch is enlarged: below, numbers on vehicles are lost
_MOST_ENLARGED = 2.0
_LOCK = threading.Lock()  # the library keeps state between its steps
# One thread: reports are read side by side, and sums in one order give one result.
_SETTINGS = {
    "Global.log_level": "critical",
    "EngineConfig.onnxruntime.intra_op_num_threads": 1,
    "EngineConfig.onnxruntime.inter_op_num_threads": 1,
}
_MEND = "install the release that config/requirements/sketch.txt names"
_WIDE = re.compile(r"[\uff01-\uff5e]")  # full-width forms, which the library's alphabet has too


@dataclass(frozen=True, slots=True)
class SketchWord:
    """A piece of writing, as far as it stands in one line without a wide gap.

    Attributes:
        text: what it says.
        box: around it, upright [pixels].
        confidence: the library's, from 0 to 1.
    """

    text: str
    box: Box
    confidence: float

    @property
    def centre(self) -> tuple[float, float]:
        """Of the box [pixels]."""
        return (self.box.left + self.box.right) / 2, (self.box.top + self.box.bottom) / 2

    @property
    def height(self) -> float:
        """Of the box [pixels]."""
        return self.box.bottom - self.box.top


@cache
def _engine() -> RapidOCR:
    """The library with the models of its own wheel: named, so that it never looks for others on the network."""
    folder = Path(rapidocr.__file__).parent / "models"
    models = {}
    for step in ("Det", "Cls", "Rec"):
        files = sorted(folder.glob(f"*_{step.lower()}_*.onnx"))
        if len(files) != 1:
            raise InputError("rapidocr", f"has {len(files)} models for {step} in its wheel, not one", _MEND)
        models[f"{step}.model_path"] = str(files[0])
    return RapidOCR(params={**_SETTINGS, **models})


def read_words(picture: SketchPicture) -> tuple[SketchWord, ...]:
    """All words, from top to bottom and from left to right."""
    scale = min(max(1.0, _SHORT_SIDE / min(picture.width, picture.height)), _MOST_ENLARGED)
    image: Any = picture.colours[..., ::-1]
    if scale > 1.0:
        image = cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_CUBIC)
    with _LOCK:
        found = _engine()(np.ascontiguousarray(image), use_det=True, use_cls=True, use_rec=True)
    if found.boxes is None or found.txts is None or found.scores is None:
        return ()
    words = [
        SketchWord(_narrowed(text), _box_around(corners / scale, picture), float(score))
        for corners, text, score in zip(np.asarray(found.boxes, float), found.txts, found.scores, strict=True)
        if score >= _TRUSTED and text.strip()
    ]
    return tuple(sorted(words, key=lambda word: (word.box.top, word.box.left)))


def read_crops(crops: Sequence[Pixels]) -> list[tuple[str, float]]:
    """What each of some small pictures (RGB) says, read as one line, and the library's confidence."""
    if not crops:
        return []
    with _LOCK:
        return [_crop_text(crop) for crop in crops]


def _crop_text(crop: Pixels) -> tuple[str, float]:
    found = _engine()(np.ascontiguousarray(crop[..., ::-1]), use_det=False, use_cls=False, use_rec=True)
    if not found.txts or not found.scores:
        return "", 0.0
    return _narrowed(found.txts[0]).strip(), float(found.scores[0])


def in_lines(words: Iterable[SketchWord]) -> list[list[SketchWord]]:
    """Words that stand side by side at one height, from left to right: the rows of a table come together again."""
    lines: list[list[SketchWord]] = []
    for word in sorted(words, key=lambda word: word.box.left):
        for line in lines:
            last = line[-1]
            near = word.box.left - last.box.right < 8 * max(last.height, word.height)
            if near and abs(last.centre[1] - word.centre[1]) < 0.5 * min(last.height, word.height):
                line.append(word)
                break
        else:
            lines.append([word])
    return sorted(lines, key=lambda line: (line[0].box.top, line[0].box.left))


def box_of(words: Iterable[SketchWord]) -> Box:
    """Around some words, at least one."""
    boxes = [word.box for word in words]
    return Box(
        min(box.left for box in boxes),
        min(box.top for box in boxes),
        max(box.right for box in boxes),
        max(box.bottom for box in boxes),
    )


def _narrowed(text: str) -> str:
    return _WIDE.sub(lambda match: chr(ord(match[0]) - 0xFEE0), text)


def _box_around(corners: Any, picture: SketchPicture) -> Box:
    left, top = (max(0.0, math.floor(value)) for value in corners.min(axis=0))
    right, bottom = corners.max(axis=0)
    return Box(left, top, max(left, min(float(right), picture.width)), max(top, min(float(bottom), picture.height)))
